// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Checks that sharing does not slow bodies down. Prints, per predictor and motion, the largest
// difference in speed between two peers on the slowest link and a single peer, as a fraction of the
// latter's speed.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace {

using namespace tandem;
using consensus::SessionTime;
using pbd::Vec3;

constexpr double kRate = 60.0;
constexpr double kSeconds = 3.0;
constexpr SessionTime kStart = 1'000'000'000;  // ns
constexpr SessionTime kPhase = 7'000'000;      // ns, of the second peer's steps
constexpr double kMass = 0.3;                  // kg
// s: the throw, long enough after the start that its user has full authority.
constexpr double kSwingUp = 1.5, kSwingEnd = 1.9;

/// One peer's world with one shared ball.
class Site {
 public:
  Site(consensus::Transport& transport, const consensus::PeerOptions& options, SessionTime first)
      : peer_(world_, transport, options), first_(first) {}

  double since() const { return 1e-9 * static_cast<double>(first_ - kStart); }
  void share(const Vec3& position, const Vec3& velocity) {
    pbd::BodyDef def;
    def.pose.position = position;
    def.twist.linear = velocity;
    def.mass = kMass;
    def.inertia = pbd::Mat3::Identity() * 0.4 * kMass * 0.05 * 0.05;
    ball_ = world_.add_body(def);
    peer_.share({.id = consensus::SharedId::from_name("ball"), .body = ball_, .owner = {}});
  }
  SessionTime time(int step) const { return first_ + std::llround(1e9 * step / kRate); }
  void begin(int step) {
    if (user) user(*this, 1e-9 * static_cast<double>(time(step) - kStart), time(step));
    peer_.before_step(time(step));
    solver_.step(world_, 1e-9 * static_cast<double>(time(step + 1) - time(step)));
    speeds.push_back(world_.twist(ball_).linear.norm());
  }
  void end(int step) { peer_.after_step(time(step + 1)); }
  pbd::World& world() { return world_; }
  pbd::BodyId ball() const { return ball_; }
  consensus::Peer& peer() { return peer_; }

  std::function<void(Site&, double, SessionTime)> user;  ///< acts before each step
  std::vector<double> speeds;                            ///< m/s, after each step

 private:
  pbd::World world_;
  pbd::Solver solver_;
  consensus::Peer peer_;
  pbd::BodyId ball_;
  SessionTime first_;
};

using Build = std::function<void(Site&, bool first)>;

struct Motion {
  const char* name;
  Build build;
  double from;  ///< s, start of the comparison
};

/// m/s of both peers (or of one alone) after each step.
std::array<std::vector<double>, 2> run(const Motion& motion, consensus::PredictorKind predictor,
                                       int only) {
  consensus::VirtualNetwork network(consensus::network_profile(5), 1, kStart);
  consensus::PeerOptions options;
  options.predictor = predictor;
  std::vector<std::unique_ptr<Site>> sites(2);
  for (int i = 0; i < 2; ++i) {
    consensus::Transport& transport = network.transport(static_cast<consensus::PeerId>(i + 1));
    if (only >= 0 && only != i) continue;
    auto& site = sites[static_cast<std::size_t>(i)];
    site = std::make_unique<Site>(transport, options, kStart + i * kPhase);
    motion.build(*site, i == 0);
  }
  const int steps = static_cast<int>(kSeconds * kRate);
  for (int step = 0; step <= steps; ++step) {
    // A step's end is the next one's beginning.
    for (const auto& site : sites) {
      if (!site) continue;
      network.advance_to(site->time(step));
      if (step > 0) site->end(step - 1);
      if (step < steps) site->begin(step);
    }
  }
  std::array<std::vector<double>, 2> result;
  for (std::size_t i = 0; i < 2; ++i) {
    if (sites[i]) result[i] = sites[i]->speeds;
  }
  return result;
}

double difference(const Motion& motion, consensus::PredictorKind predictor) {
  const auto shared = run(motion, predictor, -1);
  double largest = 0.0;
  for (int i = 0; i < 2; ++i) {
    const auto peer = static_cast<std::size_t>(i);
    const std::vector<double> alone = run(motion, predictor, i)[peer];
    if (alone.empty()) continue;
    const double fastest = *std::max_element(alone.begin(), alone.end());
    for (std::size_t step = 0; step < alone.size(); ++step) {
      if (static_cast<double>(step) < motion.from * kRate) continue;
      largest = std::max(largest, std::abs(shared[peer][step] - alone[step]) / fastest);
    }
  }
  return largest;
}

/// In flight since the start, at any phase of the steps.
Build flight(const Vec3& velocity, const Vec3& off) {
  return [=](Site& site, bool first) {
    const double t = site.since();
    const Vec3 g = site.world().gravity();
    const Vec3 aside = first ? Vec3(Vec3::Zero()) : off;
    site.share(Vec3(0, 0, 50) + aside + t * velocity + 0.5 * t * t * g, velocity + t * g);
  };
}

/// A ball on a rod of 1 m, released at 0.5 rad; a later peer starts where it is by then.
void pendulum(Site& site, bool /*first*/) {
  const double t = site.since();
  const double spin = -site.world().gravity().norm() * std::sin(0.5) * t;  // rad/s
  const double angle = 0.5 + 0.5 * spin * t;
  const Vec3 along(std::sin(angle), 0.0, -std::cos(angle));
  site.share(along, spin * Vec3(std::cos(angle), 0.0, std::sin(angle)));
  auto& joints = site.world().add_block<pbd::JointBlock>();
  joints.add(site.world(), pbd::BallJointDef{.b = site.ball(), .frame_b = {.anchor = -along}});
}

/// The first peer's hand holds, swings and releases the ball, with the motion of the single run, so
/// that only the sharing differs.
void thrown(Site& site, bool first) {
  site.share(Vec3::Zero(), Vec3::Zero());
  if (!first) return;
  auto grip = std::make_shared<consensus::GrabId>();
  site.user = [grip](Site& s, double since_start, SessionTime now) {
    const Vec3 way(1.2, 0.0, 0.8);
    if (since_start > kSwingEnd) {
      if (grip->spring != 0) s.peer().release(*grip);
      *grip = {};
      return;
    }
    const double part = std::max(0.0, since_start - kSwingUp) / (kSwingEnd - kSwingUp);
    const Vec3 hand = part * part * way;
    if (grip->spring == 0) {
      *grip = s.peer().grab({.body = consensus::SharedId::from_name("ball"),
                             .anchor_w = hand,
                             .stiffness = 500.0,
                             .damping = 20.0});
    }
    s.peer().move(*grip, hand, now);
  };
}

}  // namespace

int main() {
  // The throw runs at the first peer alone: the second has no thrower.
  const std::array<Motion, 4> motions{
      Motion{"fall", flight(Vec3::Zero(), Vec3::Zero()), 0.0},
      Motion{"fall, 3 cm apart at first", flight(Vec3::Zero(), Vec3(0.03, 0.0, 0.0)), 0.0},
      Motion{"throw", flight(Vec3(4, 0, 6), Vec3::Zero()), 0.0}, Motion{"swing", pendulum, 0.0}};
  std::printf("{\n");
  const std::array<std::pair<const char*, consensus::PredictorKind>, 2> predictors{
      std::pair{"replay", consensus::PeerOptions{}.predictor},
      std::pair{"euler", consensus::PredictorKind::Euler}};
  for (std::size_t k = 0; k < predictors.size(); ++k) {
    std::printf("  \"%s\": {\n", predictors[k].first);
    for (const Motion& motion : motions) {
      std::printf("    \"%s\": %.6g,\n", motion.name, difference(motion, predictors[k].second));
    }
    const Motion by_hand{"throw by hand", thrown, kSwingEnd + 0.3};
    const std::vector<double> shared = run(by_hand, predictors[k].second, -1)[0];
    const std::vector<double> alone = run(by_hand, predictors[k].second, 0)[0];
    double largest = 0.0;
    for (auto step = static_cast<std::size_t>(by_hand.from * kRate); step < alone.size(); ++step) {
      largest = std::max(largest, std::abs(shared[step] / alone[step] - 1.0));
    }
    std::printf("    \"%s\": %.6g\n  }%s\n", by_hand.name, largest,
                k + 1 < predictors.size() ? "," : "");
  }
  std::printf("}\n");
  return 0;
}
