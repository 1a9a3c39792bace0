// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/session.h"

namespace tandem {

/// Ids of removed bodies, so that late messages do not revive them. The oldest are dropped, which
/// bounds the memory.
class RemovedIds {
 public:
  static constexpr std::size_t kMaxIds = 4096;

  void add(const SharedId& id);
  bool contains(const SharedId& id) const { return known_.contains(id); }
  const std::deque<SharedId>& in_order() const { return order_; }

 private:
  std::set<SharedId> known_;
  std::deque<SharedId> order_;
};

/// Bodies that members spawn for everybody, by events (docs/sessions.md):
///
///     tandem.spawn    the body's state as in a packet (kHeaderBytes + kStateBytes), then `what`
///     tandem.despawn  ids, 16 bytes each, little-endian
/// request for all bodies; to each member that connects
/// end of the answer
///
/// A member names its own bodies; others' only until its answer is complete.
class Spawns {
 public:
  /// All arguments but the options must outlive it.
  Spawns(const SpawnOptions& options, pbd::World& world, consensus::Peer& peer,
         consensus::EventChannel& events);

  /// See Session.
  SharedId spawn(std::string_view what, const pbd::Pose& pose, const pbd::Twist& twist,
                 SessionTime now);
  void despawn(const SharedId& id);
  void join(PeerId member);
  void leave(PeerId member) { members_.erase(member); }
  /// Process the events of the last poll, at session time `now`. @throws what SpawnOptions'
  /// functions throw
  void receive(SessionTime now);
  std::uint64_t refused() const { return refused_; }

 private:
  struct Here {
    pbd::BodyId body;
    std::string what;
  };
  struct Member {
    bool told = false;         ///< has sent all its bodies
    bool asks = false;         ///< has asked and was not answered yet
    SessionTime answered = 0;  ///< ns, of the last answer; 0 = never
  };

  void add(const consensus::StateUpdate& state, std::string_view what);
  void forget(const SharedId& id);
  /// @param times  multiple of the limits in the options that may be used
  bool has_room(const SharedId& id, std::size_t times) const;
  void tell(const SharedId& id, const Here& here, PeerId to);
  void tell_removed(std::span<const SharedId> ids, PeerId to);
  void tell_all(PeerId member);
  void hear(const consensus::Event& event);
  bool hear_spawn(const consensus::Event& event);
  bool hear_despawn(const consensus::Event& event);

  SpawnOptions options_;
  pbd::World& world_;
  consensus::Peer& peer_;
  consensus::EventChannel& events_;
  std::map<SharedId, Here> here_;
  RemovedIds removed_;  ///< bodies that were here
  RemovedIds unknown_;  ///< removed before they came; only this list can be filled by others
  std::map<PeerId, Member> members_;
  std::uint64_t last_ = 0;  ///< number of the last id made here
  std::uint64_t refused_ = 0;
  std::vector<std::byte> bytes_;
  consensus::DecodedPacket packet_;
};

}  // namespace tandem
