// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "support/toy_contacts.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/tether.h"

/// Peers with one shared body each, in one process and in virtual time.
namespace tandem::consensus::testing {

using pbd::Pose;
using pbd::Quat;
using pbd::Twist;
using pbd::Vec3;

inline constexpr SessionTime kStart = 1'000'000'000;  ///< ns
inline const SharedId kBody = SharedId::from_name("body");

inline SessionTime ns(double seconds) { return std::llround(1e9 * seconds); }

/// By name: g++ 12 takes a temporary in the member's initialiser for dangling.
inline pbd::SolverOptions without_clock() {
  pbd::SolverOptions options;
  options.measure_stages = false;
  return options;
}

/// One peer's world and its place in time.
struct Site {
  Site(Transport& transport, const PeerOptions& options, const pbd::WorldDef& def)
      : world(def), peer(std::make_unique<Peer>(world, transport, options)), id(transport.self()) {}

  pbd::World world;
  pbd::Solver solver{without_clock()};
  tandem::testing::ToyContacts contacts;
  std::unique_ptr<Peer> peer;
  PeerId id;
  pbd::BodyId body;
  std::function<void(Site&, SessionTime)> user;     ///< acts before each step
  std::function<void(Site&, SessionTime)> coupled;  ///< acts when the peer is ready for the step

  /// Add the shared body.
  void share(const pbd::BodyDef& def, std::optional<PeerId> owner = std::nullopt) {
    body = world.add_body(def);
    peer->share({.id = kBody, .body = body, .owner = owner});
  }
  const Pose& pose() const { return world.pose(body); }
  const Twist& twist() const { return world.twist(body); }
  const Vec3& x() const { return pose().position; }
  const Vec3& v() const { return twist().linear; }
  void displace(const Vec3& by) { world.set_pose(body, {x() + by, pose().orientation}); }
  const pbd::Tethers& tethers() const {
    for (const auto& block : world.blocks()) {
      if (const auto* found = dynamic_cast<const pbd::Tethers*>(block.get())) return *found;
    }
    throw std::logic_error("a peer adds a block of tethers");
  }

  // Set by Session.
  double hz = 60.0;
  SessionTime first = 0;
  std::int64_t steps = 0;
  bool inside = false;  ///< the step is computed and waits for its end to come

  SessionTime step_time(std::int64_t step) const {
    return first + std::llround(static_cast<double>(step) * 1e9 / hz);
  }
  /// Of the world's state.
  SessionTime world_time() const { return step_time(inside ? steps + 1 : steps); }
  /// Ends (0) come before beginnings (1), so that simultaneous peers hear each other's last step.
  std::tuple<SessionTime, int> next() const {
    return inside ? std::tuple{step_time(steps + 1), 0} : std::tuple{step_time(steps), 1};
  }
};

/// m, at the same time: a peer's steps end up to one step apart from the other's.
inline double gap_now(const Site& a, const Site& b) {
  const double ahead = 1e-9 * static_cast<double>(a.world_time() - b.world_time());
  return (a.x() - (b.x() + ahead * b.v())).norm();
}
inline double gap(const Site& a, const Site& b) { return (a.x() - b.x()).norm(); }

class Session {
 public:
  explicit Session(const LinkOptions& link = {}, SessionTime start = kStart, std::uint64_t seed = 1)
      : network(link, seed, start), start_(start), end_(start) {}

  VirtualNetwork network;
  std::vector<std::unique_ptr<Site>> sites;
  std::function<void(Site&)> after;  ///< after each step of each peer

  /// A peer whose first step begins `phase` s from now.
  Site& add(PeerId id, double phase, const PeerOptions& options = {}, const pbd::WorldDef& def = {},
            double hz = 60.0) {
    sites.push_back(std::make_unique<Site>(network.transport(id), options, def));
    sites.back()->hz = hz;
    sites.back()->first = network.now() + ns(phase);
    return *sites.back();
  }
  Site& operator[](std::size_t index) { return *sites[index]; }

  void run(double seconds) {
    end_ += ns(seconds);
    while (true) {
      Site* first = nullptr;
      for (const auto& site : sites) {
        if (first == nullptr || site->next() < first->next()) first = site.get();
      }
      if (first == nullptr || std::get<0>(first->next()) > end_) break;
      network.advance_to(std::get<0>(first->next()));
      act(*first);
    }
    network.advance_to(end_);
  }
  /// s since the start.
  double time() const { return 1e-9 * static_cast<double>(end_ - start_); }

 private:
  void act(Site& site) {
    const SessionTime from = site.step_time(site.steps);
    const SessionTime to = site.step_time(site.steps + 1);
    if (!site.inside) {
      if (site.user) site.user(site, from);
      site.peer->before_step(from);
      if (site.coupled) site.coupled(site, from);
      site.solver.step(site.world, 1e-9 * static_cast<double>(to - from));
      site.inside = true;
    } else {
      site.peer->after_step(to);
      ++site.steps;
      site.inside = false;
      if (after) after(site);
    }
  }

  SessionTime start_;
  SessionTime end_;
};

// Bodies and surroundings -------------------------------------------------------------------------

inline constexpr double kBallRadius = 0.1;  ///< m
inline const Vec3 kHalf = Vec3::Constant(0.1);

/// 1 kg.
inline pbd::BodyDef ball(const Vec3& position, const Vec3& velocity = Vec3::Zero()) {
  return {.pose = {position, Quat::Identity()},
          .twist = {velocity, Vec3::Zero()},
          .mass = 1.0,
          .inertia = pbd::Mat3::Identity() * (0.4 * kBallRadius * kBallRadius)};
}
/// 1 kg.
inline pbd::BodyDef cube(const Vec3& position, const Quat& orientation = Quat::Identity()) {
  return {.pose = {position, orientation},
          .mass = 1.0,
          .inertia = pbd::Mat3::Identity() * (2.0 / 3.0 * kHalf.x() * kHalf.x())};
}
/// The plane z = 0 under the shared cube.
inline void put_on_plane(Site& site, double friction = 0.5) {
  const pbd::BodyId ground = site.world.add_body({.type = pbd::BodyType::Static});
  site.contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, site.body, kHalf, {.friction = friction});
  site.world.set_contact_source(&site.contacts);
}
/// The plane z = 0 under the shared ball.
inline void put_ball_on_plane(Site& site, double restitution) {
  const pbd::BodyId ground = site.world.add_body({.type = pbd::BodyType::Static});
  site.contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, site.body, kBallRadius,
                              {.friction = 0.5, .restitution = restitution});
  site.world.set_contact_source(&site.contacts);
}

/// States do not count, so that only springs hold peers together.
inline PeerOptions springs_only() { return {.influence = {.baseline = 0.0}}; }

inline const pbd::WorldDef kWeightless{.gravity = Vec3::Zero()};

}  // namespace tandem::consensus::testing
