// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "run.h"

#include <memory>
#include <vector>

#include "../../demos/session/published_rules.h"
#include "noise.h"

namespace tandem::extreme_bench {
namespace {

using peers_bench::Session;
using peers_bench::Site;

consensus::PeerOptions options_of(const Scene& scene, const Scheme& scheme, std::size_t peer) {
  const Conditions& conditions = scene.conditions;
  consensus::PeerOptions options;
  options.coupling = scheme.coupling;
  options.two_step_thresholds = scheme.published;
  // All have long been in the session.
  options.authority_ramp = 0.0;
  // A peer that hears only some of the others cannot identify outliers.
  options.robust.outvote = scene.topology == Topology::Mesh;
  if (peer < conditions.update_hz.size()) options.update_hz = conditions.update_hz[peer];
  if (conditions.share > 0.0) options.influence.baseline = conditions.share;
  if (conditions.closing_share > 0.0) options.replay.share = conditions.closing_share;
  return scheme.published ? consensus::with_published_rules(options) : options;
}

/// No gravity before that time, s.
void lighten(Site& site, double until) {
  const Vec3 gravity = site.copy.world->gravity();
  site.copy.world->set_gravity(Vec3::Zero());
  site.user = [=](Site& s, double time) {
    if (time >= until && s.copy.world->gravity() != gravity) s.copy.world->set_gravity(gravity);
  };
}

/// Adds a hand at its peer.
void lend(Site& site, const Hand& hand) {
  auto id = std::make_shared<consensus::GrabId>();
  const auto before = site.user;
  site.user = [=](Site& s, double time) {
    if (before) before(s, time);
    const Vec3 at = hand.path(time);
    if (id->spring == 0) {
      *id = s.peer.grab({.body = peers_bench::shared_id(hand.body),
                         .attachment_l = hand.attachment_l,
                         .anchor_w = at,
                         .stiffness = hand.stiffness,
                         .damping = hand.damping});
    }
    s.peer.move(*id, at, s.clock(time));
  };
}

void connect(Session& session, Topology topology) {
  const auto peers = static_cast<int>(session.sites.size());
  for (int a = 1; a <= peers; ++a) {
    for (int b = 1; b <= peers; ++b) {
      const int way = (b - a + peers) % peers;
      const bool ring = way == 1 || way == peers - 1;
      const bool star = a == 1 || b == 1;
      const bool heard = topology == Topology::Mesh || (topology == Topology::Ring ? ring : star);
      if (a != b && !heard) {
        session.network.cut(static_cast<consensus::PeerId>(a), static_cast<consensus::PeerId>(b));
      }
    }
  }
}

}  // namespace

consensus::LinkOptions link_of(const std::string& name) {
  if (name == "profile 5") return consensus::network_profile(5);
  return {.latency = peers_bench::latency_of(std::stoi(name))};
}

Result run(const Scene& scene, const Scheme& scheme, const std::string& link, std::uint64_t seed) {
  const Conditions& conditions = scene.conditions;
  consensus::LinkOptions way = link_of(link);
  way.loss = conditions.loss;
  Session session(way, seed);
  std::vector<std::unique_ptr<NoisyTransport>> noisy;
  for (int i = 0; i < scene.peers; ++i) {
    const auto peer = static_cast<std::size_t>(i);
    consensus::Transport* transport = &session.network.transport(peer + 1);
    if (conditions.noise > 0.0 || conditions.noise_angle > 0.0) {
      noisy.push_back(std::make_unique<NoisyTransport>(*transport, conditions.noise,
                                                       conditions.noise_angle, 100 * seed + peer));
      transport = noisy.back().get();
    }
    session.sites.push_back(std::make_unique<Site>(
        scene.build(i), *transport, options_of(scene, scheme, peer),
        peer < conditions.pace.size() ? conditions.pace[peer] : peers_bench::Pace{},
        conditions.owners));
    if (scene.weight_from > 0.0) lighten(*session.sites.back(), scene.weight_from);
  }
  for (const Hand& hand : scene.hands)
    lend(*session.sites[static_cast<std::size_t>(hand.peer)], hand);
  connect(session, scene.topology);
  Watch watch(scene, session);
  const int samples = static_cast<int>(scene.seconds * scene.sample_hz);
  for (int k = 1; k <= samples; ++k) {
    session.run_until(k / scene.sample_hz);
    watch.look();
  }
  return watch.finish();
}

}  // namespace tandem::extreme_bench
