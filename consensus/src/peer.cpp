// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include <cmath>

#include "peer_impl.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;

void SendOptions::validate() const {
  const auto in = [](const char* field, double value, double low, double high, const char* rule) {
    require(value >= low && value <= high, "SendOptions", field, value, rule);
  };
  require(kbit_per_s == 0.0 || (kbit_per_s >= 8.0 && kbit_per_s <= 1e9), "SendOptions",
          "kbit_per_s", kbit_per_s, "0 or from 8 to 1e9");
  in("packet_overhead", packet_overhead, 0.0, 1000.0, "from 0 to 1000 bytes");
  in("tolerance", tolerance, 0.0, 1e3, "from 0 to 1000 m");
  require(angle_tolerance > 0.0 && angle_tolerance <= 10.0, "SendOptions", "angle_tolerance",
          angle_tolerance, "above 0 and at most 10 rad");
  in("refresh", refresh, 0.0, 3600.0, "from 0 to 3600 s");
  in("rest_refresh", rest_refresh, 0.0, 3600.0, "from 0 to 3600 s");
}

void PeerOptions::validate() const {
  influence.validate();
  sending.validate();
  prediction.validate();
  replay.validate();
  robust.validate();
  plausibility.validate();
  require(update_hz >= 1e-3 && update_hz <= 10000.0, "PeerOptions", "update_hz", update_hz,
          "from 0.001 to 10000");
  require(authority_ramp >= 0.0 && std::isfinite(authority_ramp), "PeerOptions", "authority_ramp",
          authority_ramp, "finite and >= 0 s");
  require(max_future >= 0.0 && max_future <= 86400.0, "PeerOptions", "max_future", max_future,
          "from 0 to 86400 s");
  // Times in nanoseconds are 64 bit: a day is as good as never, and fits.
  constexpr double kLongest = 86400.0;
  require(spring_timeout > 0.0 && spring_timeout <= kLongest, "PeerOptions", "spring_timeout",
          spring_timeout, "above 0 and at most 86400 s");
  require(max_anchor_extrapolation >= 0.0 && max_anchor_extrapolation <= kLongest, "PeerOptions",
          "max_anchor_extrapolation", max_anchor_extrapolation, "from 0 to 86400 s");
  require(anchor_velocity_filter > 0.0 && std::isfinite(anchor_velocity_filter), "PeerOptions",
          "anchor_velocity_filter", anchor_velocity_filter, "finite and > 0 s");
}

Peer::Peer(pbd::World& world, Transport& transport, const PeerOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(world, transport, options);
  world.set_target_source(this);
}
Peer::~Peer() { impl_->release_world(this); }

void Peer::share(const ShareDef& def) { impl_->share(def); }
void Peer::set_owner(const SharedId& id, std::optional<PeerId> owner) {
  impl_->set_owner(id, owner);
}
void Peer::unshare(const SharedId& id) { impl_->unshare(id); }
std::optional<SessionTime> Peer::heard(const SharedId& id, PeerId from) const {
  return impl_->heard(id, from);
}
std::span<const UnknownState> Peer::unknown() const { return impl_->unknown(); }
GrabId Peer::grab(const GrabDef& def) { return impl_->grab(def); }
void Peer::move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now) {
  impl_->springs().move(id, anchor_w, now);
}
void Peer::release(GrabId id) { impl_->springs().release(id, impl_->now()); }
std::optional<PeerId> Peer::owner(const SharedId& id) const { return impl_->owner(id); }
bool Peer::held(const SharedId& id) const { return impl_->held(id); }
void Peer::springs(std::vector<pbd::Tether::Def>& out) const { impl_->springs().pulls(out); }
void Peer::note_contact(pbd::BodyId a, pbd::BodyId b) { impl_->note_contact(a, b); }
void Peer::before_step(SessionTime now) { impl_->before_step(now); }
void Peer::after_step(SessionTime now) { impl_->after_step(now); }
void Peer::leave(SessionTime now) { impl_->leave(now); }
const PeerStats& Peer::stats() const { return impl_->stats(); }
std::span<const PeerReport> Peer::reports() const { return impl_->reports(); }
void Peer::set_observer(PeerObserver* observer) { impl_->set_observer(observer); }
void Peer::set_replay_hook(ReplayHook* hook) { impl_->set_replay_hook(hook); }
void Peer::set_interest(const Interest* interest) { impl_->set_interest(interest); }

void Peer::collect(const pbd::World& /*world*/, double /*dt*/, const pbd::SolverOptions& options,
                   std::vector<pbd::PoseTarget>& out) {
  impl_->collect(options, out);
}

}  // namespace tandem::consensus
