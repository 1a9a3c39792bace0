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
#include <memory>
#include <numbers>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "../../demos/session/published_rules.h"
#include "copies/measures.h"
#include "copies/session.h"
#include "scenes.h"

namespace {

using namespace tandem;
using namespace tandem::stability_bench;
using pbd::Vec3;
using peers_bench::Site;

constexpr double kRate = 60.0;
constexpr int kSteps = 240;
constexpr double kApart = 0.05;   // m
constexpr double kNoise = 2e-4;   // m, of each copy's bodies at the start
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

consensus::PeerOptions options_of(const Scheme& scheme) {
  consensus::PeerOptions options;
  options.coupling = scheme.coupling;
  options.authority_ramp = 0.0;
  if (scheme.published) options = consensus::with_published_rules(options);
  options.two_step_thresholds = scheme.thresholds;
  return options;
}

/// The same noise for all schemes. Jointed bodies keep their joints.
void add_noise(peers_bench::Copy& copy, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (const pbd::BodyId body : copy.bodies) {
    pbd::Pose pose = copy.world->pose(body);
    pose.position.x() += kNoise * (static_cast<double>(random() >> 11) * 0x1p-52 - 1.0);
    copy.world->set_pose(body, pose);
  }
}

/// A user of this peer shakes a body from where it was laid out.
void shake(Site& site, std::size_t body, const Vec3& from, double hz) {
  const consensus::GrabId hand = site.peer.grab({.body = peers_bench::shared_id(body),
                                                 .anchor_w = from,
                                                 .stiffness = 150.0,
                                                 .damping = 5.0,
                                                 .max_force = 6.0});
  site.user = [hand, from, hz](Site& here, double time) {
    const double angle = 2.0 * std::numbers::pi * hz * time;
    here.peer.move(hand, from + kSwing * std::sin(angle) * Vec3::UnitX(), here.clock(time));
  };
}

/// Largest and mean over time, m.
struct Extent {
  double largest = 0.0;
  double mean = 0.0;

  void add(double value, double weight) {
    largest = std::max(largest, value);
    mean += weight * value;
  }
};

void run(const Scheme& scheme, std::size_t kind, bool hands, int profile, std::uint64_t seed,
         int substeps, int iterations) {
  peers_bench::Session session(consensus::network_profile(profile), seed);
  const pbd::SolverOptions solver{
      .substeps = substeps, .position_iterations = iterations, .measure_stages = false};
  const bool chain = kKinds[kind] == Kind::Chain;
  std::vector<std::vector<Vec3>> laid_out;  // m, by peer and body
  for (const consensus::PeerId id : {1, 2}) {
    peers_bench::Copy copy = build(kKinds[kind], id == 1 ? 0.0 : kApart);
    std::vector<Vec3>& places = laid_out.emplace_back();
    for (const pbd::BodyId body : copy.bodies) places.push_back(copy.world->pose(body).position);
    if (!chain) add_noise(copy, 2 * seed + id);
    session.sites.push_back(std::make_unique<Site>(std::move(copy), session.network.transport(id),
                                                   options_of(scheme), peers_bench::Pace{}, false,
                                                   solver));
  }
  Site& a = *session.sites[0];
  Site& b = *session.sites[1];
  if (hands) {
    // Of a chain the end and the middle, else the first and the last body.
    const std::size_t last = a.copy.bodies.size() - 1;
    const std::size_t of_a = chain ? last : 0;
    const std::size_t of_b = chain ? last / 2 : last;
    shake(a, of_a, laid_out[0][of_a], 0.9);
    shake(b, of_b, laid_out[1][of_b], 0.7);
  }
  double whole = 0.0, second_half = 0.0, last = 0.0, middle = 0.0;
  Extent overlap, opening;
  for (int k = 0; k < kSteps; ++k) {
    session.run_until((k + 1) / kRate);
    const double difference = peers_bench::apart(a.copy, b.copy);
    whole += difference / kSteps;
    if (k >= kSteps / 2) second_half += 2.0 * difference / kSteps;
    if (k >= kSteps / 2 && k < 3 * kSteps / 4) middle = std::max(middle, difference);
    if (k >= 3 * kSteps / 4) last = std::max(last, difference);
    for (const Site* site : {&a, &b}) {
      overlap.add(peers_bench::deepest_overlap(site->copy), 0.5 / kSteps);
      opening.add(peers_bench::widest_joint(site->copy), 0.5 / kSteps);
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
  if (!a.copy.boxes.empty()) {
    std::printf("%.4g,%.4g,,,", 1e3 * overlap.largest, 1e3 * overlap.mean);
  } else if (chain) {
    std::printf(",,%.4g,%.4g,", 1e3 * opening.largest, 1e3 * opening.mean);
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
      "scheme,scene,hands,profile,seed,substeps,iterations,cpu_us,apart_mm,apart_late_mm,"
      "overlap_max_mm,overlap_mean_mm,joint_max_mm,joint_mean_mm,stable");
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
