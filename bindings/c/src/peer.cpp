// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include <optional>

#include "convert.h"
#include "guard.h"
#include "transport_impl.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

consensus::SharedId id_of(tandem_shared_id id) { return {id.high, id.low}; }

std::int64_t checked_now(std::int64_t now_ns) { return checked_time("now_ns", now_ns, 1); }

}  // namespace

struct tandem_peer {
  consensus::Peer peer;
};

void tandem_peer_def_init(tandem_peer_def* def) {
  if (def == nullptr) return;
  const consensus::PeerOptions defaults;
  *def = {.update_hz = defaults.update_hz,
          .influence = defaults.influence.baseline,
          .authority_ramp = defaults.authority_ramp,
          .compact = 0,
          .tolerance = defaults.sending.tolerance,
          .kbit_per_s = defaults.sending.kbit_per_s,
          .replay_budget = defaults.replay.budget};
}

tandem_peer* tandem_peer_create(tandem_world* world, tandem_transport* transport,
                                const tandem_peer_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_peer_def& d = required(def, "def");
    tandem_world& w = required(world, "world");
    consensus::PeerOptions options;
    options.update_hz = d.update_hz;
    options.influence.baseline = d.influence;
    options.authority_ramp = d.authority_ramp;
    options.sending.format =
        d.compact != 0 ? consensus::StateFormat::Compact : consensus::StateFormat::Full;
    options.sending.tolerance = d.tolerance;
    options.sending.kbit_per_s = d.kbit_per_s;
    options.replay.budget = d.replay_budget;
    if (w.world.target_source() != nullptr) {
      pbd::detail::refuse("world", "one that has no peer yet");
    }
    return new tandem_peer{.peer = {w.world, *required(transport, "transport").transport, options}};
  });
}

void tandem_peer_destroy(tandem_peer* peer) { delete peer; }

tandem_shared_id tandem_shared_id_of(const char* name) {
  if (name == nullptr) return {0, 0};
  const consensus::SharedId id = consensus::SharedId::from_name(name);
  return {id.high, id.low};
}

tandem_result tandem_peer_share(tandem_peer* peer, tandem_shared_id id, tandem_body body,
                                uint64_t owner, tandem_error* error) {
  return guarded(error, [&] {
    required(peer, "peer")
        .peer.share({.id = id_of(id),
                     .body = from_c(body),
                     .owner = owner != 0 ? std::optional(owner) : std::nullopt});
  });
}

tandem_result tandem_peer_unshare(tandem_peer* peer, tandem_shared_id id, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.unshare(id_of(id)); });
}

tandem_result tandem_peer_before_step(tandem_peer* peer, int64_t now_ns, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.before_step(checked_now(now_ns)); });
}

tandem_result tandem_peer_after_step(tandem_peer* peer, int64_t now_ns, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.after_step(checked_now(now_ns)); });
}

tandem_result tandem_peer_leave(tandem_peer* peer, int64_t now_ns, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.leave(checked_now(now_ns)); });
}

void tandem_grab_def_init(tandem_grab_def* def) {
  if (def == nullptr) return;
  const consensus::GrabDef defaults;
  *def = {};
  def->stiffness = defaults.stiffness;
  def->damping = defaults.damping;
  def->max_force = defaults.max_force;
}

tandem_result tandem_peer_grab(tandem_peer* peer, const tandem_grab_def* def, uint32_t* grab,
                               tandem_error* error) {
  return guarded(error, [&] {
    const tandem_grab_def& d = required(def, "def");
    uint32_t& out = required(grab, "grab");
    out = required(peer, "peer")
              .peer
              .grab({.body = id_of(d.body),
                     .attachment_l = from_c(d.attachment),
                     .anchor_w = from_c(d.anchor),
                     .stiffness = d.stiffness,
                     .damping = d.damping,
                     .max_force = d.max_force})
              .spring;
  });
}

tandem_result tandem_peer_move(tandem_peer* peer, uint32_t grab, tandem_vec3 anchor, int64_t now_ns,
                               tandem_error* error) {
  return guarded(error, [&] {
    required(peer, "peer").peer.move({grab}, from_c(anchor), checked_now(now_ns));
  });
}

tandem_result tandem_peer_release(tandem_peer* peer, uint32_t grab, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.release({grab}); });
}

void tandem_act_def_init(tandem_act_def* def) {
  if (def == nullptr) return;
  *def = {};
  def->pose.orientation.w = 1.0;
}

tandem_result tandem_peer_act(tandem_peer* peer, const tandem_act_def* def, tandem_error* error) {
  return guarded(error, [&] {
    const tandem_act_def& d = required(def, "def");
    consensus::ActDef act{.body = id_of(d.body),
                          .impulse = from_c(d.impulse),
                          .angular_impulse = from_c(d.angular_impulse),
                          .name = d.name};
    if (d.sets_pose != 0) act.pose = from_c(d.pose);
    if (d.sets_twist != 0) act.twist = from_c(d.twist);
    required(peer, "peer").peer.act(act);
  });
}

void tandem_peer_get_stats(const tandem_peer* peer, tandem_peer_stats* stats) {
  if (stats == nullptr) return;
  *stats = {};
  if (peer == nullptr) return;
  const consensus::PeerStats& from = peer->peer.stats();
  *stats = {.updates_received = from.updates_received,
            .packets_received = from.packets_received,
            .packets_rejected = from.packets_rejected,
            .bytes_sent = from.bytes_sent,
            .bodies_placed = from.bodies_placed};
}
