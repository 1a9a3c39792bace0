// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include "convert.h"
#include "guard.h"
#include "sharing.h"
#include "transport_impl.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

std::int64_t checked_now(std::int64_t now_ns) { return checked_time("now_ns", now_ns, 1); }

}  // namespace

struct tandem_peer {
  consensus::Peer peer;
};

void tandem_peer_def_init(tandem_peer_def* def) {
  if (def == nullptr) return;
  *def = to_c(consensus::PeerOptions());
}

tandem_peer* tandem_peer_create(tandem_world* world, tandem_transport* transport,
                                const tandem_peer_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const consensus::PeerOptions options = from_c(required(def, "def"));
    tandem_world& w = required(world, "world");
    if (w.world.target_source() != nullptr) {
      pbd::detail::refuse("world", "one that has no peer yet");
    }
    return new tandem_peer{.peer = {w.world, *required(transport, "transport").transport, options}};
  });
}

void tandem_peer_destroy(tandem_peer* peer) { delete peer; }

tandem_shared_id tandem_shared_id_of(const char* name) {
  if (name == nullptr) return {0, 0};
  return to_c(consensus::SharedId::from_name(name));
}

tandem_result tandem_peer_share(tandem_peer* peer, tandem_shared_id id, tandem_body body,
                                uint64_t owner, tandem_error* error) {
  return guarded(error, [&] {
    required(peer, "peer")
        .peer.share({.id = from_c(id), .body = from_c(body), .owner = owner_of(owner)});
  });
}

tandem_result tandem_peer_unshare(tandem_peer* peer, tandem_shared_id id, tandem_error* error) {
  return guarded(error, [&] { required(peer, "peer").peer.unshare(from_c(id)); });
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
    const consensus::GrabDef wanted = from_c(required(def, "def"));
    uint32_t& out = required(grab, "grab");
    out = required(peer, "peer").peer.grab(wanted).spring;
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
    const consensus::ActDef wanted = from_c(required(def, "def"));
    required(peer, "peer").peer.act(wanted);
  });
}

void tandem_peer_get_stats(const tandem_peer* peer, tandem_peer_stats* stats) {
  if (stats == nullptr) return;
  *stats = peer != nullptr ? to_c(peer->peer.stats()) : tandem_peer_stats{};
}
