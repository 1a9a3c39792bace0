// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/virtual_coupling.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "consensus/peer_fixture.h"
#include "session/published_rules.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::demos::virtual_coupling_test {
namespace {

using namespace consensus;
using namespace consensus::testing;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kFrame = 1.0 / 60.0;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Peers whose bodies are pulled together, with the paper's prediction and rules.
struct Pulled {
  explicit Pulled(const LinkOptions& link = {}, const VirtualCouplingOptions& pull = {},
                  PeerOptions published = {}, double rate = 60.0)
      : session(link), options(pull), rules(with_published_rules(std::move(published))), hz(rate) {
    rules.robust.max_correction = rules.robust.max_velocity_correction = kUnlimited;
  }
  Site& add(PeerId id, const pbd::WorldDef& def, double phase = 0.0) {
    Site& site = session.add(id, phase, rules, def, hz);
    pulls.push_back(std::make_unique<VirtualCoupling>(site.world, *site.peer, options));
    site.coupled = [pull = pulls.back().get()](Site&, SessionTime now) { pull->pull(now); };
    return site;
  }
  Site& operator[](std::size_t index) { return session[index]; }
  void run(double seconds) { session.run(seconds); }

  Session session;
  VirtualCouplingOptions options;
  PeerOptions rules;
  double hz;
  std::vector<std::unique_ptr<VirtualCoupling>> pulls;
};

/// e'' + 2 z w e' + w^2 e = 0 from rest at 1, z <= 1.
double oscillator(double w, double z, double t) {
  if (z > 1.0 - 1e-9) return (1.0 + w * t) * std::exp(-w * t);
  const double wd = w * std::sqrt(1.0 - z * z);
  return std::exp(-z * w * t) * (std::cos(wd * t) + z * w / wd * std::sin(wd * t));
}

TEST_CASE("virtual coupling: what it leaves between two free bodies is a damped oscillator",
          "[demos][analytic]") {
  // At 1 kHz implicit Euler is within w dt of the exact solution.
  const double ratio = GENERATE(0.7071067811865476, 0.2);
  const VirtualCouplingOptions options{.damping_ratio = ratio};
  Pulled session({}, options, {.update_hz = 1000.0}, 1000.0);
  for (PeerId id = 1; id <= 2; ++id) session.add(id, kWeightless).share(ball(Vec3::Zero()));
  Site& a = session[0];
  Site& b = session[1];
  session.run(0.01);
  b.world.set_pose(b.body, {Vec3(0.3, 0.0, 0.0), Quat(Eigen::AngleAxisd(0.2, Vec3::UnitZ()))});
  session.run(0.002);
  // Both pull: twice the stiffness and twice the damping for what is between them.
  const double w = std::sqrt(2.0) * 2.0 * std::numbers::pi * options.frequency;
  const double z = std::sqrt(2.0) * ratio;
  for (int i = 1; i <= 10; ++i) {
    session.run(0.1);
    const double t = 0.1 * i;
    INFO("t = " << t << ", damping ratio " << z);
    CHECK((b.x().x() - a.x().x()) / 0.3 == Approx(oscillator(w, z, t)).margin(0.01));
    const double angle = a.pose().orientation.angularDistance(b.pose().orientation);
    CHECK(angle / 0.2 == Approx(std::abs(oscillator(w, z, t))).margin(0.015));
    // Equal and opposite: the middle stays.
    CHECK(a.x().x() + b.x().x() == Approx(0.3).epsilon(1e-6));
  }
}

TEST_CASE("virtual coupling: its force is cut, in proportion to the mass", "[demos][analytic]") {
  const double mass = GENERATE(0.1, 10.0);
  Pulled session;
  for (PeerId id = 1; id <= 2; ++id) {
    pbd::BodyDef def = ball(Vec3::Zero());
    def.mass = mass;
    session.add(id, kWeightless).share(def);
  }
  session.run(0.1);
  session[1].displace({1000.0, 0.0, 0.0});
  session.run(2.0 * kFrame);
  const double before = session[0].v().x();
  session.run(kFrame);
  CHECK(session[0].v().x() - before ==
        Approx(VirtualCouplingOptions{}.max_acceleration * kFrame).epsilon(1e-6));
}

TEST_CASE("virtual coupling: at its defaults it settles over every profile", "[demos]") {
  const int profile = GENERATE(1, 2, 3, 4, 5);
  const bool resting = GENERATE(true, false);
  Pulled session(network_profile(profile));
  for (PeerId id = 1; id <= 2; ++id) {
    Site& site =
        session.add(id, resting ? pbd::WorldDef{} : kWeightless, 0.007 * static_cast<double>(id));
    site.share(cube({0.0, 0.0, kHalf.z()}));
    if (resting) put_on_plane(site, 0.05);
  }
  session.run(0.5);
  session[1].displace({0.3, 0.0, 0.0});
  double fastest = 0.0;
  session.session.after = [&](Site& site) { fastest = std::max(fastest, site.v().norm()); };
  session.run(10.0);
  CAPTURE(profile, resting);
  // Friction holds what the spring cannot move, (1 + 2 z w dt) mu g / w^2 = 5.4 cm. What moves does
  // so together: while the news was under way only one of them was pulled.
  CHECK(gap(session[0], session[1]) < (resting ? 0.055 : 1e-3));
  CHECK((session[0].v() - session[1].v()).norm() < 1e-3);
  CHECK(fastest < 2.0);
}

TEST_CASE("virtual coupling: options outside of their rules are refused by name",
          "[demos][fault]") {
  const auto refused = [](const VirtualCouplingOptions& options) {
    return refusal([&] { options.validate(); });
  };
  CHECK(names(refused({.frequency = 0.0}), "frequency", "is 0", "above 0"));
  CHECK(names(refused({.damping_ratio = -0.1}), "damping_ratio", "-0.1", "0 to 100"));
  CHECK(names(refused({.max_acceleration = 0.0}), "max_acceleration", "is 0", "> 0"));
}

}  // namespace
}  // namespace tandem::demos::virtual_coupling_test
