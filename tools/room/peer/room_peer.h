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

/// One native participant of a room: simulates all of it, and may pull bodies.
/// @par Thread safety  One object: one thread at a time.
class RoomPeer {
 public:
  /// @param scene  text of the room's file     @param profile  JSON: name and colour
  RoomPeer(const Address& address, MemberId self, std::string_view scene, std::string profile);
  ~RoomPeer();
  RoomPeer(const RoomPeer&) = delete;
  RoomPeer& operator=(const RoomPeer&) = delete;

  /// Runs due steps. @return how many; 0 before the server has sent its time
  int advance();

  /// Holds a body at its centre and moves the hand to `to` (m, world) at a person's pace. False if
  /// no such movable body exists.
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
  int until_hand_ = 0;               ///< steps until the next message about the hand
  std::optional<Hand> hand_;
  std::vector<std::string> made_;                         ///< JSON of bodies made by members
  std::map<MemberId, consensus::SessionTime> told_made_;  ///< ns, time of sending them to a member
  std::vector<RoomTransport::Heard> heard_;
  std::vector<MemberId> newcomers_;
};

}  // namespace tandem::room
