// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/live_worlds.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tandem::demos::view {

using consensus::SessionTime;

LiveWorlds::LiveWorlds(const Scenario& scenario, const DemoOptions& options,
                       const std::vector<Input>* replay)
    : session_(scenario, options, replay) {
  std::vector<Actor>& actors = session_.actors();
  peers_.resize(actors.size());
  for (std::size_t i = 0; i < actors.size(); ++i) {
    Participant& participant = actors[i].participant();
    Peer& peer = peers_[i];
    peer.actor = &actors[i];
    peer.watch = std::make_unique<PaneWatch>(participant.scene());
    participant.watch_with(peer.watch.get());
    participant.add_user(scenario.user_count() + i, kVirtualStart, [&peer](Controls& controls) {
      auto mouse = std::make_unique<Mouse>(controls);
      peer.mouse = mouse.get();
      return mouse;
    });
    if (options.endless) participant.record_nothing();
    keep_poses(peer);
  }
}

LiveWorlds::~LiveWorlds() { session_.close_traces(); }

void LiveWorlds::keep_poses(Peer& peer) {
  const Scene& world = peer.actor->participant().scene();
  peer.before_time = peer.actor->reached();
  peer.before.resize(world.bodies.size());
  for (std::size_t body = 0; body < peer.before.size(); ++body) {
    peer.before[body] = world.pose(body);
  }
}

void LiveWorlds::advance_to(SessionTime end) {
  while (true) {
    Peer& next = peers_[next_actor(session_.actors())];
    const auto [time, kind] = next.actor->next();
    if (time > end) return;
    if (kind == 1) keep_poses(next);
    session_.act(end);
  }
}

void LiveWorlds::set_links(const DemoOptions& options) { options.set_links(session_.network()); }

void LiveWorlds::change_rules(const DemoOptions& options) {
  // Drops states of the replaced peers. Reliable packets still arrive: a recent grip may pull twice
  // until silent for a second.
  for (std::size_t from = 1; from <= size(); ++from) {
    for (std::size_t to = 1; to <= size(); ++to) {
      if (from == to) continue;
      session_.network().cut(from, to);
      session_.network().heal(from, to);
    }
  }
  for (Peer& peer : peers_) {
    peer.actor->participant().change_rules(options);
    peer.watch->forget();
  }
}

double LiveWorlds::show_poses(const Peer& peer, SessionTime now,
                              std::vector<pbd::Pose>& out) const {
  const Scene& world = peer.actor->participant().scene();
  const SessionTime reached = peer.actor->reached();
  const auto step = static_cast<double>(reached - peer.before_time);
  const double share =
      step > 0.0 ? std::clamp(static_cast<double>(now - peer.before_time) / step, 0.0, 1.0) : 1.0;
  out.resize(peer.before.size());
  for (std::size_t body = 0; body < out.size(); ++body) {
    const pbd::Pose& from = peer.before[body];
    const pbd::Pose& to = world.pose(body);
    out[body].position = from.position + share * (to.position - from.position);
    out[body].orientation = from.orientation.slerp(share, to.orientation);
  }
  return (1.0 - share) * 1e-9 * step;
}

void LiveWorlds::show(SessionTime now, std::span<PaneFrame> out, std::size_t first, bool overlays) {
  for (std::size_t i = 0; i < size(); ++i) {
    const Participant& participant = peers_[i].actor->participant();
    PaneFrame& pane = out[i];
    pane.step_ms = 1e3 * participant.last_step_s();
    pane.latency_ms = 1e3 * peers_[i].watch->mean_age();
    const double ahead = show_poses(peers_[i], now, pane.poses);
    show_springs(i, first, ahead, pane);
    pane.contacts.clear();
    pane.targets.clear();
    pane.influence.assign(pane.poses.size(), 0);
    if (overlays) show_overlays(i, first, pane);
  }
  show_divergence(out);
}

void LiveWorlds::show_overlays(std::size_t peer, std::size_t first, PaneFrame& out) {
  append_contacts(scene(peer), out.poses, out.contacts);
  for (const PaneWatch::Target& target : peers_[peer].watch->targets()) {
    const bool here = target.peer >= 1 && target.peer <= size();
    const std::size_t of = first + static_cast<std::size_t>(target.peer) - 1;
    out.targets.push_back({static_cast<std::uint16_t>(target.body),
                           here ? static_cast<std::uint16_t>(of) : TargetMark::kElsewhere,
                           target.position});
  }
  for (std::size_t body = 0; body < out.influence.size(); ++body) {
    // A peer's share is the maximum that the others received from it.
    double share = 0.0;
    for (std::size_t other = 0; other < size(); ++other) {
      if (other != peer) share = std::max(share, peers_[other].watch->share(peer + 1, body));
    }
    out.influence[body] = static_cast<std::uint8_t>(std::lround(255.0 * std::min(share, 1.0)));
  }
}

void LiveWorlds::show_springs(std::size_t peer, std::size_t first, double ahead, PaneFrame& out) {
  const Participant& participant = peers_[peer].actor->participant();
  pulls_.clear();
  participant.peer().springs(pulls_);
  for (pbd::Tether::Def& pull : pulls_) pull.anchor_w -= ahead * pull.anchor_velocity;
  const auto holder = [&](std::size_t body, const pbd::Vec3& attachment_l) {
    std::uint8_t whose = SpringMark::kElsewhere;
    for (std::size_t i = 0; i < size(); ++i) {
      const Participant& other = peers_[i].actor->participant();
      if (other.holds(body, attachment_l)) whose = static_cast<std::uint8_t>(first + i);
    }
    return whose;
  };
  out.springs.clear();
  append_springs(participant.scene(), out.poses, pulls_, static_cast<std::uint8_t>(first + peer),
                 holder, out.springs);
}

void LiveWorlds::show_divergence(std::span<PaneFrame> out) {
  means_.assign(out.front().poses.size(), pbd::Vec3::Zero());
  for (const PaneFrame& pane : out) {
    for (std::size_t body = 0; body < means_.size(); ++body) {
      means_[body] += pane.poses[body].position / static_cast<double>(out.size());
    }
  }
  for (PaneFrame& pane : out) {
    lengths_.clear();
    for (std::size_t body = 0; body < means_.size() && out.size() > 1; ++body) {
      lengths_.push_back((pane.poses[body].position - means_[body]).norm());
    }
    put_divergence(lengths_, pane);
  }
}

std::vector<PeerRecord> LiveWorlds::records() {
  std::vector<PeerRecord> result;
  for (Peer& peer : peers_) result.push_back(peer.actor->participant().record());
  return result;
}

void LiveWorlds::append_outcomes(std::vector<Outcome>& out) {
  for (Peer& peer : peers_) out.push_back(peer.actor->participant().record().outcome);
}

}  // namespace tandem::demos::view
