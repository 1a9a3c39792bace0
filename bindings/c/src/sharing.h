// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>

#include "convert.h"
#include "tandem/consensus/events.h"
#include "tandem/consensus/peer.h"

namespace tandem::c {

inline consensus::SharedId from_c(tandem_shared_id id) { return {id.high, id.low}; }
inline tandem_shared_id to_c(const consensus::SharedId& id) { return {id.high, id.low}; }

/// 0 = none.
inline std::optional<consensus::PeerId> owner_of(std::uint64_t owner) {
  return owner != 0 ? std::optional(owner) : std::nullopt;
}

inline consensus::PeerOptions from_c(const tandem_peer_def& def) {
  consensus::PeerOptions options;
  options.update_hz = def.update_hz;
  options.influence.baseline = def.influence;
  options.authority_ramp = def.authority_ramp;
  options.sending.format =
      def.compact != 0 ? consensus::StateFormat::Compact : consensus::StateFormat::Full;
  options.sending.tolerance = def.tolerance;
  options.sending.kbit_per_s = def.kbit_per_s;
  options.replay.budget = def.replay_budget;
  return options;
}
inline tandem_peer_def to_c(const consensus::PeerOptions& options) {
  return {.update_hz = options.update_hz,
          .influence = options.influence.baseline,
          .authority_ramp = options.authority_ramp,
          .compact = options.sending.format == consensus::StateFormat::Compact ? 1 : 0,
          .tolerance = options.sending.tolerance,
          .kbit_per_s = options.sending.kbit_per_s,
          .replay_budget = options.replay.budget};
}

inline consensus::GrabDef from_c(const tandem_grab_def& def) {
  return {.body = from_c(def.body),
          .attachment_l = from_c(def.attachment),
          .anchor_w = from_c(def.anchor),
          .stiffness = def.stiffness,
          .damping = def.damping,
          .max_force = def.max_force};
}

inline consensus::ActDef from_c(const tandem_act_def& def) {
  consensus::ActDef act{.body = from_c(def.body),
                        .impulse = from_c(def.impulse),
                        .angular_impulse = from_c(def.angular_impulse),
                        .name = def.name};
  if (def.sets_pose != 0) act.pose = from_c(def.pose);
  if (def.sets_twist != 0) act.twist = from_c(def.twist);
  return act;
}

inline tandem_peer_stats to_c(const consensus::PeerStats& stats) {
  return {.updates_received = stats.updates_received,
          .packets_received = stats.packets_received,
          .packets_rejected = stats.packets_rejected,
          .bytes_sent = stats.bytes_sent,
          .bodies_placed = stats.bodies_placed};
}

/// Valid as long as the event, which must not move.
inline tandem_event to_c(const consensus::Event& event) {
  return {.from = event.from,
          .stamp_ns = event.stamp,
          .topic = event.topic.c_str(),
          .topic_size = event.topic.size(),
          .payload = event.payload.data(),
          .payload_size = event.payload.size()};
}

}  // namespace tandem::c
