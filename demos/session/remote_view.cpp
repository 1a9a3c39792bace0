// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/remote_view.h"

#include <algorithm>

namespace tandem::demos {

RemoteView::RemoteView(const Scene& scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) index_[scene.bodies[i].id] = i;
}

bool RemoteView::body_index(const consensus::SharedId& id, std::size_t& index) const {
  const auto found = index_.find(id);
  if (found == index_.end()) return false;
  index = found->second;
  return true;
}

void RemoteView::look(consensus::PeerId from, std::span<const std::byte> packet,
                      const std::optional<consensus::Arrival>& arrival) {
  if (!recording_) return;
  if (!consensus::decode(packet, decoded_).ok()) return;
  const auto newest = consensus::newest_stamp(decoded_);
  if (arrival && newest) {
    consensus::shift_stamps(decoded_,
                            clocks_.hear(from, *newest, arrival->received, arrival->round_trip));
  }
  Remote& remote = remotes_[from];
  remote.tracks.resize(index_.size());
  std::size_t body = 0;
  for (const consensus::SpringUpdate& spring : decoded_.springs) look(remote, spring);
  if (!decoded_.leaves.empty()) remote.springs.clear();
  for (const consensus::StateUpdate& state : decoded_.states) {
    if (!body_index(state.id, body)) continue;
    TrackSample sample;
    sample.time = state.stamp;
    sample.position = state.pose.position;
    sample.orientation = state.pose.orientation;
    sample.speed = state.twist.linear.norm();
    sample.velocity = state.twist.linear;
    // Each process has one user, however many springs the hand has.
    for (const auto& [spring, hand] : remote.springs) {
      sample.users |= hand.body == body && !hand.released ? 1 : 0;
    }
    remote.tracks[body].push(sample);
  }
}

void RemoteView::look(Remote& remote, const consensus::SpringUpdate& spring) const {
  Hand hand;
  if (!body_index(spring.body, hand.body)) return;
  hand.revision = spring.revision;
  hand.released = spring.event == consensus::SpringEvent::Remove;
  const auto known = remote.springs.find(spring.spring);
  if (known != remote.springs.end()) {
    // Removals are sent separately from states, and may overtake them.
    if (hand.revision < known->second.revision || known->second.released) return;
    known->second = hand;
    return;
  }
  if (remote.springs.size() == kMaxSprings) {
    // Numbers grow: the first released one is the oldest.
    const auto oldest = std::find_if(remote.springs.begin(), remote.springs.end(),
                                     [](const auto& each) { return each.second.released; });
    if (oldest == remote.springs.end()) return;
    remote.springs.erase(oldest);
  }
  remote.springs[spring.spring] = hand;
}

void RemoteView::forget_hands(consensus::PeerId peer) {
  const auto found = remotes_.find(peer);
  if (found != remotes_.end()) found->second.springs.clear();
}

std::vector<PeerRecord> RemoteView::records() const {
  std::vector<PeerRecord> records;
  for (const auto& [id, remote] : remotes_) {
    PeerRecord record;
    record.id = id;
    record.local = false;
    record.tracks = remote.tracks;
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace tandem::demos
