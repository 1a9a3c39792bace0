// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Error against processor time: two peers on the virtual links of the profiles that disagree by
// 5 cm at first; with hands, a user of each peer shakes one of the bodies as well. Prints one line
// of CSV for each run:
//
//   scheme, scene, hands, profile, seed, substeps, iterations, CPU time of one peer's step (us),
//   apart (rms over bodies, mean over the run and over its second half, mm), worst overlap and its
//   mean (mm, over steps of the deepest one), worst opening of a joint and its mean (mm), stable
//
//   error_time [seeds [profile...]]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry.h"
#include "scenes.h"
#include "scenes/random.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_link.h"
#include "tandem/pbd/solver.h"

namespace {

using namespace tandem;
using namespace tandem::stability_bench;
using consensus::SessionTime;
using pbd::Vec3;

constexpr double kRate = 60.0;
constexpr SessionTime kStart = 1'000'000'000;  // ns
constexpr int kSteps = 240;
constexpr double kApart = 0.05;   // m
constexpr double kNoise = 2e-4;   // m, of each copy's bodies at the start
constexpr double kEdge = 0.1;     // m, of the scenes' cubes
constexpr double kSwing = 0.08;   // m, of hands, to and fro
constexpr double kPlenty = 10.0;  // m: further apart is lost

struct Scheme {
  std::string_view name;
  consensus::Coupling coupling;
  bool published;
  bool thresholds;
};
constexpr Scheme kSchemes[] = {
    {"one-pass", consensus::Coupling::OnePass, false, false},
    {"two-step", consensus::Coupling::TwoStep, false, false},
    {"one-pass-plain", consensus::Coupling::OnePass, true, false},
    {"two-step-plain", consensus::Coupling::TwoStep, true, false},
    {"two-step-paper", consensus::Coupling::TwoStep, true, true},
};
/// Substeps, sweeps of the pass.
constexpr std::array<std::array<int, 2>, 7> kSettings = {
    {{1, 1}, {2, 1}, {4, 1}, {8, 1}, {16, 1}, {32, 1}, {4, 4}}};

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

consensus::PeerOptions options_of(const Scheme& scheme) {
  consensus::PeerOptions options;
  options.coupling = scheme.coupling;
  options.authority_ramp = 0.0;
  if (scheme.published) options = consensus::with_published_rules(options);
  options.two_step.thresholds = scheme.thresholds;
  return options;
}

struct Site {
  Site(Kind kind, double apart, std::uint64_t seed, consensus::Transport& transport,
       const consensus::PeerOptions& peer_options, const pbd::SolverOptions& solver_options)
      : copy(build(kind, apart)),
        solver(solver_options),
        peer(*copy.world, transport, peer_options) {
    demos::Random random(seed);
    for (std::size_t i = 0; i < copy.bodies.size(); ++i) {
      pbd::Pose pose = copy.world->pose(copy.bodies[i]);
      laid_out.push_back(pose.position);
      // Jointed bodies keep their joints.
      if (kind != Kind::Chain) {
        pose.position.x() += random.uniform(-kNoise, kNoise);
        copy.world->set_pose(copy.bodies[i], pose);
      }
      peer.share({.id = consensus::SharedId::from_name("body/" + std::to_string(i)),
                  .body = copy.bodies[i]});
    }
  }
  /// @param body  shaken by this peer's user     @param hz  how often
  void take_hold(std::size_t body, double hz) {
    hand_from = laid_out[body];
    hand_hz = hz;
    hand = peer.grab({.body = consensus::SharedId::from_name("body/" + std::to_string(body)),
                      .anchor_w = hand_from,
                      .stiffness = 150.0,
                      .damping = 5.0,
                      .max_force = 6.0});
  }
  void step(int k) {
    const SessionTime from = kStart + std::llround(1e9 * k / kRate);
    const SessionTime to = kStart + std::llround(1e9 * (k + 1) / kRate);
    if (hand_hz > 0.0) {
      const double angle = 2.0 * std::numbers::pi * hand_hz * k / kRate;
      peer.move(hand, hand_from + kSwing * std::sin(angle) * Vec3::UnitX(), from);
    }
    const double before = cpu_s();
    peer.before_step(from);
    solver.step(*copy.world, 1e-9 * static_cast<double>(to - from));
    peer.after_step(to);
    cpu += cpu_s() - before;
  }
  /// m, the deepest of cubes, ground and, in the row, the wall.
  double overlap(Kind kind) const {
    const Vec3 half = Vec3::Constant(0.5 * kEdge);
    double worst = 0.0;
    for (std::size_t i = 0; i < copy.bodies.size(); ++i) {
      const pbd::Pose& pose = copy.world->pose(copy.bodies[i]);
      worst = std::max(worst, demos::ground_overlap(pose, half));
      if (kind == Kind::Row) {
        const pbd::Pose wall{Vec3(10.5 * kEdge + 0.51, 0.0, 0.5), pbd::Quat::Identity()};
        worst = std::max(worst, demos::box_overlap(pose, half, wall, Vec3(0.5, 1.0, 0.5)));
      }
      for (std::size_t j = i + 1; j < copy.bodies.size(); ++j) {
        worst =
            std::max(worst, demos::box_overlap(pose, half, copy.world->pose(copy.bodies[j]), half));
      }
    }
    return worst;
  }
  /// m, the widest open joint of the chain.
  double opening() const {
    // Links are laid out along a line, unturned: half of what is between two of them is an arm.
    const Vec3 arm = 0.5 * (laid_out[1] - laid_out[0]);
    double worst = 0.0;
    Vec3 end = Vec3::Zero();  // the hook
    for (const pbd::BodyId body : copy.bodies) {
      const pbd::Pose& pose = copy.world->pose(body);
      worst = std::max(worst, (pose.position - pose.orientation * arm - end).norm());
      end = pose.position + pose.orientation * arm;
    }
    return worst;
  }

  peers_bench::Copy copy;
  std::vector<Vec3> laid_out;  ///< m, where bodies were before noise
  pbd::Solver solver;
  consensus::Peer peer;
  double cpu = 0.0;  ///< s
  consensus::GrabId hand;
  Vec3 hand_from = Vec3::Zero();  ///< m
  double hand_hz = 0.0;           ///< 0 = nobody's
};

double apart(const Site& a, const Site& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.copy.bodies.size(); ++i) {
    sum += (a.copy.world->pose(a.copy.bodies[i]).position -
            b.copy.world->pose(b.copy.bodies[i]).position)
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.copy.bodies.size()));
}

void run(const Scheme& scheme, std::size_t kind, bool hands, int profile, std::uint64_t seed,
         int substeps, int iterations) {
  consensus::VirtualNetwork network(consensus::network_profile(profile), seed, kStart);
  network.transport(1);
  network.transport(2);
  const pbd::SolverOptions solver{
      .substeps = substeps, .position_iterations = iterations, .measure_stages = false};
  const consensus::PeerOptions options = options_of(scheme);
  Site a(kKinds[kind], 0.0, 2 * seed, network.transport(1), options, solver);
  Site b(kKinds[kind], kApart, 2 * seed + 1, network.transport(2), options, solver);
  const bool touching = a.copy.contacts != nullptr && kKinds[kind] != Kind::Chain &&
                        (kKinds[kind] == Kind::Row || kKinds[kind] == Kind::Stack);
  if (hands) {
    // Of a chain the end and the middle, else the first and the last body.
    const std::size_t last_body = a.copy.bodies.size() - 1;
    a.take_hold(kKinds[kind] == Kind::Chain ? last_body : 0, 0.9);
    b.take_hold(kKinds[kind] == Kind::Chain ? last_body / 2 : last_body, 0.7);
  }
  double whole = 0.0, second_half = 0.0, last = 0.0, middle = 0.0;
  double overlap_max = 0.0, overlap_sum = 0.0, opening_max = 0.0, opening_sum = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    network.advance_to(kStart + std::llround(1e9 * k / kRate));
    a.step(k);
    b.step(k);
    const double difference = apart(a, b);
    whole += difference / kSteps;
    if (k >= kSteps / 2) second_half += 2.0 * difference / kSteps;
    if (k >= kSteps / 2 && k < 3 * kSteps / 4) middle = std::max(middle, difference);
    if (k >= 3 * kSteps / 4) last = std::max(last, difference);
    for (const Site* site : {&a, &b}) {
      if (touching) {
        const double overlap = site->overlap(kKinds[kind]);
        overlap_max = std::max(overlap_max, overlap);
        overlap_sum += overlap / (2 * kSteps);
      }
      if (kKinds[kind] == Kind::Chain) {
        const double opening = site->opening();
        opening_max = std::max(opening_max, opening);
        opening_sum += opening / (2 * kSteps);
      }
    }
  }
  // Hands go on disturbing: what they do must not grow.
  const double most = hands ? 2.0 * kApart : 1.05 * middle;
  const bool stable = std::isfinite(last) && last < kPlenty &&
                      (last < 1e-3 * kApart || (last < 2.0 * kApart && last <= most));
  std::printf("%.*s,%.*s,%d,%d,%d,%d,%d,%.4g,%.4g,%.4g,", static_cast<int>(scheme.name.size()),
              scheme.name.data(), static_cast<int>(kKindNames[kind].size()),
              kKindNames[kind].data(), hands ? 1 : 0, profile, static_cast<int>(seed), substeps,
              iterations, 1e6 * (a.cpu + b.cpu) / (2 * kSteps), 1e3 * whole, 1e3 * second_half);
  if (touching) {
    std::printf("%.4g,%.4g,,,", 1e3 * overlap_max, 1e3 * overlap_sum);
  } else if (kKinds[kind] == Kind::Chain) {
    std::printf(",,%.4g,%.4g,", 1e3 * opening_max, 1e3 * opening_sum);
  } else {
    std::printf(",,,,");
  }
  std::printf("%d\n", stable ? 1 : 0);
}

}  // namespace

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  std::vector<int> profiles;
  for (int i = 2; i < argc; ++i) profiles.push_back(std::clamp(std::atoi(argv[i]), 1, 5));
  if (profiles.empty()) profiles = {3, 5};
  std::puts(
      "scheme,scene,hands,profile,seed,substeps,iterations,cpu_us,apart_mm,apart_late_mm,overlap_"
      "max_mm,"
      "overlap_mean_mm,joint_max_mm,joint_mean_mm,stable");
  for (const int profile : profiles) {
    for (std::size_t each = 0; each < 2 * kKinds.size(); ++each) {
      const std::size_t kind = each / 2;
      const bool hands = each % 2 == 1;
      if (kKinds[kind] == Kind::Free) continue;
      for (const Scheme& scheme : kSchemes) {
        for (int seed = 1; seed <= seeds; ++seed) {
          for (const auto& [substeps, iterations] : kSettings) {
            run(scheme, kind, hands, profile, static_cast<std::uint64_t>(seed), substeps,
                iterations);
          }
        }
      }
    }
  }
  return 0;
}
