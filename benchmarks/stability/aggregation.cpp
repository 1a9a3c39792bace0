// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// One target that is the mean of all peers' states, against one row for each peer, swept. Prints
// one line of CSV for each number of peers and sweeps (0: the mean):
//
//   peers, sweeps, miss (of the way to the weighted mean of [friston] Eqs. 1 and 2, rms over
//   bodies, position and rotation), CPU time for each body and step (ns)
//
// A row is x = x_i with compliance 1 / (m w_i); all rows of a body together have the mean as their
// solution. A step has four substeps with a share of each: the mean is made once, rows are swept in
// each of them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "benchmarks/measure/clock.h"
#include "scenes/random.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/math.h"

namespace {

using namespace tandem;
using consensus::PeerEstimate;
using pbd::Vec3;

constexpr std::size_t kBodies = 2000;
constexpr int kSubsteps = 4;
constexpr int kRepeats = 9;
constexpr double kShare = 0.08;     // largest announced; peers' are spread down to half of it
constexpr double kDistance = 0.05;  // m
constexpr double kAngle = 0.2;      // rad

struct Body {
  pbd::Pose pose;
  std::vector<PeerEstimate> heard;
};

std::vector<Body> make_bodies(int peers) {
  demos::Random random(static_cast<std::uint64_t>(peers));
  const auto within = [&random](double limit) {
    return Vec3(random.uniform(-limit, limit), random.uniform(-limit, limit),
                random.uniform(-limit, limit));
  };
  std::vector<Body> bodies(kBodies);
  for (Body& body : bodies) {
    for (int i = 0; i < peers; ++i) {
      PeerEstimate& heard = body.heard.emplace_back();
      heard.peer = static_cast<consensus::PeerId>(i + 2);
      heard.pose = {within(kDistance), pbd::rotated(pbd::Quat::Identity(), within(kAngle))};
      heard.share = random.uniform(0.5 * kShare, kShare);
    }
  }
  return bodies;
}

/// The pose after a step in which each substep closes its part of the share.
pbd::Pose by_mean(Body& body) {
  pbd::PoseTarget target;
  consensus::fuse(body.pose, body.heard, target);
  pbd::Pose pose = body.pose;
  const double part = 1.0 - std::pow(1.0 - target.share, 1.0 / kSubsteps);
  Vec3 miss = target.pose.position - pose.position;
  Vec3 turn = target.rotation_error;
  for (int i = 0; i < kSubsteps; ++i) {
    pose.position += part * miss;
    pose.orientation = pbd::rotated(pose.orientation, part * turn);
    miss *= 1.0 - part;
    turn *= 1.0 - part;
  }
  return pose;
}

/// The same by rows, each with a multiplier of its own.
pbd::Pose by_rows(const Body& body, int sweeps) {
  pbd::Pose pose = body.pose;
  struct Row {
    double stiffness = 0.0;  // weight for each substep
    Vec3 push = Vec3::Zero();
    Vec3 turn = Vec3::Zero();
  };
  std::array<Row, 32> rows;
  double sum = 0.0;
  for (const PeerEstimate& heard : body.heard) sum += consensus::weight_of_share(heard.share);
  // Substeps' weights are such that all of them together close the whole share.
  const double whole = consensus::share_of_weight(sum);
  const double weight = consensus::weight_of_share(1.0 - std::pow(1.0 - whole, 1.0 / kSubsteps));
  for (std::size_t i = 0; i < body.heard.size(); ++i) {
    rows[i].stiffness = weight * consensus::weight_of_share(body.heard[i].share) / sum;
  }
  for (int substep = 0; substep < kSubsteps; ++substep) {
    for (Row& row : rows) row.push = row.turn = Vec3::Zero();
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      for (std::size_t i = 0; i < body.heard.size(); ++i) {
        Row& row = rows[i];
        const double compliance = 1.0 / row.stiffness;
        const Vec3 gap = pose.position - body.heard[i].pose.position;
        const Vec3 push = (-gap - compliance * row.push) / (1.0 + compliance);
        row.push += push;
        pose.position += push;
        const Vec3 error = pbd::rotation_between(body.heard[i].pose.orientation, pose.orientation);
        const Vec3 turn = (-error - compliance * row.turn) / (1.0 + compliance);
        row.turn += turn;
        pose.orientation = pbd::rotated(pose.orientation, turn);
      }
    }
  }
  return pose;
}

void run(int peers, int sweeps) {
  std::vector<Body> bodies = make_bodies(peers);
  std::vector<pbd::Pose> found(bodies.size());
  std::vector<double> times;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const double before = bench::thread_seconds();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      found[i] = sweeps == 0 ? by_mean(bodies[i]) : by_rows(bodies[i], sweeps);
    }
    times.push_back(bench::thread_seconds() - before);
  }
  std::sort(times.begin(), times.end());
  double missed = 0.0, way = 0.0, misturned = 0.0, turned = 0.0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    pbd::PoseTarget target;
    consensus::fuse(bodies[i].pose, bodies[i].heard, target);
    const Vec3 move = target.share * (target.pose.position - bodies[i].pose.position);
    const Vec3 turn = target.share * target.rotation_error;
    missed += (found[i].position - bodies[i].pose.position - move).squaredNorm();
    way += move.squaredNorm();
    misturned +=
        pbd::rotation_between(pbd::rotated(bodies[i].pose.orientation, turn), found[i].orientation)
            .squaredNorm();
    turned += turn.squaredNorm();
  }
  std::printf("%d,%d,%.3g,%.3g,%.4g\n", peers, sweeps, std::sqrt(missed / way),
              std::sqrt(misturned / turned), 1e9 * times[kRepeats / 2] / kBodies);
}

}  // namespace

int main() {
  std::puts("peers,sweeps,miss_position,miss_rotation,cpu_ns");
  for (const int peers : {1, 3, 7, 15}) {
    for (const int sweeps : {0, 1, 2, 4, 8}) run(peers, sweeps);
  }
  return 0;
}
