// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What hangs by joints or springs: by the time news of a difference comes, it has turned.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "consensus/peer_fixture.h"
#include "consensus/random.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"

namespace tandem::consensus::swing_test {
namespace {

using namespace testing;
using pbd::Vec3;

constexpr SessionTime kStep = 16'666'667;  // ns
constexpr int kLate = 5;                   // steps

struct Errors {
  double predicted = 0.0;  ///< m, rms of what the prediction misses, once it has had time to learn
  double believed = 0.0;   ///< m, rms of the prediction itself
};

/// The own copy hangs still, the other one is where `x` says; both by a joint.
template <class Where>
Errors run(const Where& x) {
  const auto predictor = make_predictor(PredictorKind::Adaptive);
  PredictorMemory memory;
  MotionHistory own;
  Errors errors;
  int count = 0;
  for (int i = 0; i < 600; ++i) {
    own.push(kStart + i * kStep, {}, {}, {}, true);
    if (i < kLate) continue;
    StateUpdate update;
    update.id = {1, 1};
    update.pose.position.x() = x(i - kLate);
    update.twist.linear.x() = 30.0 * (x(i - kLate + 1) - x(i - kLate - 1));
    update.stamp = kStart + (i - kLate) * kStep;
    update.flags.in_contact = true;
    const double said =
        predictor
            ->predict(update, own, {.now = kStart + i * kStep, .hangs = true, .memory = &memory})
            .translation.x();
    if (i < 200) continue;
    ++count;
    errors.predicted += (said - x(i)) * (said - x(i));
    errors.believed += said * said;
  }
  errors.predicted = std::sqrt(errors.predicted / count);
  errors.believed = std::sqrt(errors.believed / count);
  return errors;
}

TEST_CASE("swing: of one mode it is known where the difference is by now",
          "[consensus][analytic]") {
  // Up to a quarter of a turn; after it the fit would have to push against what it sees.
  const double phase = GENERATE(0.3, 0.8, 1.3);  // rad within the age
  CAPTURE(phase);
  const double w = phase / kLate;  // rad a step
  const Errors errors = run([w](int i) { return 0.02 * std::sin(w * i); });
  const double rms = 0.02 / std::sqrt(2.0);
  CHECK(errors.predicted < 0.1 * rms);
  // Taken as it was seen it is off by the chord.
  CHECK(errors.predicted < 0.3 * 2.0 * std::sin(0.5 * phase) * rms);
}

TEST_CASE("swing: a difference that comes as it likes is left alone", "[consensus][unit]") {
  Dice dice(1);
  std::vector<double> noise(700);
  for (double& value : noise) value = dice.uniform(-0.02, 0.02);
  const Errors errors = run([&](int i) { return noise[static_cast<std::size_t>(i + 1)]; });
  // What nothing foretells is best left as it is: 0.02 / sqrt(3) off.
  CHECK(errors.believed < 0.1 * 0.02 / std::sqrt(3.0));
}

/// Ten links of 0.2 m and 1 kg that hang from a hook.
std::vector<pbd::BodyId> hang_chain(Site& site, double angle) {
  constexpr double kLink = 0.2;  // m
  const Vec3 down(std::sin(angle), 0.0, -std::cos(angle));
  auto& joints = site.world.add_block<pbd::JointBlock>();
  pbd::BodyId above = site.world.add_body({.type = pbd::BodyType::Static});
  std::vector<pbd::BodyId> links;
  for (int i = 0; i < 10; ++i) {
    pbd::BodyDef def = ball((i + 0.5) * kLink * down);
    def.can_sleep = false;
    const pbd::BodyId link = site.world.add_body(def);
    joints.add(site.world, pbd::ball_joint_at(site.world, above, link, i * kLink * down));
    site.peer->share({.id = SharedId::from_name("link/" + std::to_string(i)), .body = link});
    links.push_back(link);
    above = link;
  }
  return links;
}

struct Apart {
  double early = 0.0;  ///< m, largest rms over the links in the middle third
  double late = 0.0;   ///< and in the last one
  double speed = 0.0;  ///< m/s, rms in the last third, of both
};

Apart chain_of(double delay) {
  Session session({.latency = delay});
  Site& a = session.add(1, 0.0, {.authority_ramp = 0.0});
  Site& b = session.add(2, 0.0, {.authority_ramp = 0.0});
  const auto here = hang_chain(a, 0.0);
  const auto there = hang_chain(b, 0.05);
  Apart apart;
  int steps = 0;
  session.after = [&](Site& site) {
    if (&site != &b) return;
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < here.size(); ++i) {
      sum += (a.world.pose(here[i]).position - b.world.pose(there[i]).position).squaredNorm();
      squares += a.world.twist(here[i]).linear.squaredNorm();
      squares += b.world.twist(there[i]).linear.squaredNorm();
    }
    const double rms = std::sqrt(sum / 10.0);
    ++steps;
    if (steps > 600) {
      apart.late = std::max(apart.late, rms);
      apart.speed += squares;
    } else if (steps > 300) {
      apart.early = std::max(apart.early, rms);
    }
  };
  session.run(15.0);
  apart.speed = std::sqrt(apart.speed / (20.0 * (steps - 600)));
  return apart;
}

TEST_CASE("swing: chains of which one hung aside come to agree, and the swing stays",
          "[consensus][long]") {
  const double frames = GENERATE(0.0, 3.0, 8.0, 15.0);
  CAPTURE(frames);
  const Apart apart = chain_of(frames / 60.0);
  // At first 5 cm rms: 0.05 rad of a chain of 2 m. Modes up to 6 Hz turn round within 3 frames, and
  // pushed by old news they grew to more than that.
  constexpr double kFirst = 0.05 * 2.0 / 1.7320508;
  CHECK(apart.late < 0.25 * kFirst);
  CHECK(apart.late < 1.1 * apart.early + 1e-4);
  if (frames > 3.0) return;
  // The mean of a swing and of none is half as far: 0.025 rad, of whose energy m g h half is in
  // motion in the mean. Those speeds are the physics', and agreement should leave them.
  const double expected = std::sqrt(0.5 * 9.81 * 2.0 * 0.5) * 0.025;
  CHECK(apart.speed > 0.6 * expected);
  CHECK(apart.speed < 1.3 * expected);
}

}  // namespace
}  // namespace tandem::consensus::swing_test
