// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "peer/room_scene.h"
#include "peer/room_transport.h"
#include "tandem/consensus/peer.h"

namespace tandem::room {

/// One native participant of a room: simulates all of it, as a page does, and may pull at bodies.
/// @par Thread safety  One object: one thread at a time.
class RoomPeer {
 public:
  /// @param scene  text of the room's file     @param profile  JSON: name and colour
  RoomPeer(const Address& address, MemberId self, std::string_view scene, std::string profile);
  ~RoomPeer();
  RoomPeer(const RoomPeer&) = delete;
  RoomPeer& operator=(const RoomPeer&) = delete;

  /// Makes the steps that are due. @return how many; 0 before the server has said what time it is
  int advance();

  /// Holds a body at its middle, and moves the hand to a point (m, world), no faster than a person
  /// would. False where there is no such body that moves.
  bool pull(std::string_view body, const Vec3& to);
  void release();

  RoomScene& scene() { return scene_; }
  RoomTransport& transport() { return transport_; }
  consensus::Peer& peer() { return peer_; }
  /// Session time of the world, ns.
  consensus::SessionTime time() const { return time_; }

 private:
  struct Hand {
    std::string body;
    Vec3 anchor;
    Vec3 wanted;
    consensus::GrabId spring;
  };

  void step();
  void move_hand();
  void hear();
  void hear_words(MemberId from, std::string_view text);
  void share(const RoomScene::Body& body);
  void say_made(MemberId to);
  void send_digest();
  void say_have();
  void send_hand();
  void send_all(Channel channel, const Bytes& bytes);

  RoomScene scene_;
  RoomTransport transport_;
  consensus::Peer peer_;
  consensus::SessionTime time_ = 0;
  consensus::SessionTime told_ = 0;  ///< ns, of the last digest
  int until_hand_ = 0;               ///< steps until the hand is told of again
  std::optional<Hand> hand_;
  std::vector<std::string> made_;                         ///< JSON of bodies that members have made
  std::map<MemberId, consensus::SessionTime> told_made_;  ///< ns, when a member was told of them
  std::vector<RoomTransport::Heard> heard_;
  std::vector<MemberId> newcomers_;
};

}  // namespace tandem::room
