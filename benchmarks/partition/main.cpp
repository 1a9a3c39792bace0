// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// One world solved by several peers, each with its own part of space, [friston] Sec. 8.3: what
// comes of it beside the same world solved by one. Prints one JSON object.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "demos/scenes/cliff_geometry.h"
#include "measures/json.h"
#include "session/geometry.h"
#include "site.h"
#include "tandem/consensus/virtual_network.h"

namespace {

using namespace tandem;
using namespace tandem::partition_bench;
using consensus::SessionTime;
using pbd::Vec3;

constexpr double kRate = 60.0;                 // steps a second
constexpr SessionTime kStart = 1'000'000'000;  // ns
constexpr int kSampleEvery = 6;                // steps
constexpr int kBalanceEvery = 15;              // steps

struct Options {
  Which which = Which::Cliff;
  int size = 0;  ///< balls or stacks; 0 = 1000 balls, 100 stacks
  std::size_t peers = 4;
  double latency = 0.001;  ///< s
  double seconds = 6.0;
  PartitionOptions partition;
  bool balance = true;  ///< borders move so that each peer has as many bodies
};

constexpr std::string_view kUsage =
    "usage: partition [--scene cliff|cubes] [--size N] [--peers N] [--latency S] [--seconds S]\n"
    "                 [--overlap M] [--reach M] [--balance on|off]\n";

Options parse(std::span<const std::string_view> words) {
  Options options;
  const auto real = [](double& into) {
    return [&into](demos::Argument& in) { into = in.number(0.0, 1e6, "a number from 0 to 1e6"); };
  };
  demos::read_arguments(
      words,
      {{"--scene",
        [&](demos::Argument& in) {
          const std::string_view name = in.value();
          if (name != "cliff" && name != "cubes") demos::refuse("--scene", name, "cliff or cubes");
          options.which = name == "cliff" ? Which::Cliff : Which::Cubes;
        }},
       {"--size",
        [&](demos::Argument& in) { options.size = in.number(0, 1'000'000, "an integer >= 0"); }},
       {"--peers",
        [&](demos::Argument& in) {
          options.peers = in.number(std::size_t{1}, std::size_t{64}, "an integer from 1 to 64");
        }},
       {"--latency", real(options.latency)},
       {"--seconds", real(options.seconds)},
       {"--overlap", real(options.partition.overlap)},
       {"--reach", real(options.partition.reach)},
       {"--balance", [&](demos::Argument& in) { options.balance = in.value() == "on"; }}});
  if (options.size == 0) options.size = options.which == Which::Cliff ? 1000 : 100;
  return options;
}

std::vector<PartitionCell> cells_for(const std::vector<Vec3>& places, std::size_t peers) {
  std::vector<PartitionCell> cells;
  for (const Cell& cell : split_cells(places, peers)) {
    cells.push_back({cells.size() + 1, cell});
  }
  return cells;
}

std::span<const std::byte> bytes_of(const std::vector<Vec3>& points) {
  return std::as_bytes(std::span(points.data(), points.size()));
}

std::vector<Vec3> points_of(const consensus::Packet& packet) {
  std::vector<Vec3> points(packet.bytes.size() / sizeof(Vec3));
  std::memcpy(static_cast<void*>(points.data()), packet.bytes.data(), points.size() * sizeof(Vec3));
  return points;
}

/// Percentiles of what was collected.
class Sample {
 public:
  void add(double value) { values_.push_back(value); }
  double at(double percent) {
    if (values_.empty()) return 0.0;
    const auto n = static_cast<std::size_t>(0.01 * percent * static_cast<double>(values_.size()));
    const auto it = values_.begin() + static_cast<std::ptrdiff_t>(std::min(n, values_.size() - 1));
    std::nth_element(values_.begin(), it, values_.end());
    return *it;
  }
  std::size_t size() const { return values_.size(); }

 private:
  std::vector<double> values_;
};

void write(demos::JsonWriter& json, std::string_view name, Sample& sample) {
  json.key(name).begin_object();
  json.field("samples", sample.size()).field("p50", sample.at(50)).field("p95", sample.at(95));
  json.field("p99", sample.at(99)).field("max", sample.at(100)).end_object();
}

/// A body as the peer that decides on it has it.
struct Known {
  pbd::Pose pose;
  std::size_t site = 0;
};

double overlap(const demos::SceneBody& a, const pbd::Pose& pose_a, const demos::SceneBody& b,
               const pbd::Pose& pose_b) {
  const auto* ball_a = std::get_if<collision::Sphere>(&a.parts[0].shape);
  const auto* ball_b = std::get_if<collision::Sphere>(&b.parts[0].shape);
  if (ball_a != nullptr && ball_b != nullptr) {
    return ball_a->radius + ball_b->radius - (pose_a.position - pose_b.position).norm();
  }
  if (ball_a != nullptr) {
    return demos::ball_box_overlap(pose_a.position, ball_a->radius, pose_b, b.half_extents);
  }
  if (ball_b != nullptr) return overlap(b, pose_b, a, pose_a);
  return demos::box_overlap(pose_a, a.half_extents, pose_b, b.half_extents);
}

class Run {
 public:
  explicit Run(const Options& options)
      : options_(options),
        network_({.latency = options.latency}, 1, kStart),
        control_({.latency = options.latency}, 2, kStart) {
    std::vector<Vec3> places;
    const demos::Scene whole = build_scene(options.which, options.size);
    for (const demos::SceneBody& body : whole.bodies) places.push_back(body.start);
    std::vector<PartitionCell> cells;
    if (options.peers > 1) cells = cells_for(places, options.peers);
    for (std::size_t i = 0; i < options.peers; ++i) {
      network_.transport(i + 1);
      control_.transport(i + 1);
    }
    told_.resize(options.peers);
    for (std::size_t i = 0; i < options.peers; ++i) {
      sites_.push_back(std::make_unique<Site>(build_scene(options.which, options.size),
                                              network_.transport(i + 1), cells, options.partition));
    }
    cpu_.resize(options.peers);
  }

  void run() {
    // In step, as computers of one room are.
    const int steps = static_cast<int>(options_.seconds * kRate);
    const auto time = [](int step) { return kStart + std::llround(1e9 / kRate * step); };
    for (int step = 0; step < steps; ++step) {
      network_.advance_to(time(step));
      control_.advance_to(time(step));
      if (options_.balance && sites_.size() > 1) balance(step);
      for (std::size_t s = 0; s < sites_.size(); ++s) {
        cpu_[s].push_back(sites_[s]->step(time(step), time(step + 1)));
      }
      if ((step + 1) % kSampleEvery == 0) sample();
    }
  }

  void report(demos::JsonWriter& json) {
    json.begin_object();
    json.field("scene", options_.which == Which::Cliff ? "cliff" : "cubes");
    json.field("size", options_.size).field("peers", options_.peers);
    json.field("latency_s", options_.latency).field("seconds", options_.seconds);
    json.field("overlap_m", options_.partition.overlap);
    json.field("reach_m", options_.partition.reach);
    json.field("bodies", sites_[0]->scene().bodies.size()).field("lost", lost_);
    json.field("missing_samples", missing_).field("under_ground", under_);
    write(json, "apart_m", apart_);
    write(json, "inside_m", inside_);
    write(json, "seam_m", seam_);
    write(json, "ground_m", ground_);
    json.key("peer").begin_array();
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      double sum = 0.0;
      Sample step;
      for (const double cpu : cpu_[s]) {
        sum += cpu;
        step.add(cpu);
      }
      const PartitionStats members = sites_[s]->members();
      json.begin_object().field("step_mean_s", sum / static_cast<double>(cpu_[s].size()));
      json.field("step_p95_s", step.at(95));
      if (options_.peers > 1) {
        json.field("bytes_per_s",
                   static_cast<double>(sites_[s]->stats().bytes_sent) / options_.seconds);
        json.field("own", members.own).field("common", members.common);
        json.field("followed", members.followed);
        json.field("appeared", members.appeared).field("vanished", members.vanished);
      }
      json.end_object();
    }
    json.end_array();
    const auto bodies = known();
    Vec3 mean = Vec3::Zero();
    for (const Known& body : bodies)
      mean += body.pose.position / static_cast<double>(bodies.size());
    double spread = 0.0;
    for (const Known& body : bodies) {
      spread += (body.pose.position - mean).squaredNorm() / static_cast<double>(bodies.size());
    }
    json.key("middle_m").begin_array().value(mean.x()).value(mean.y()).value(mean.z()).end_array();
    json.field("spread_m", std::sqrt(spread));
    json.end_object();
  }

 private:
  /// Every body as the peer that decides has it; nobody's are as the first one has them.
  std::vector<Known> known() {
    std::vector<Known> bodies(sites_[0]->scene().bodies.size(), Known{{}, sites_.size()});
    lost_ = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      std::size_t first = sites_.size();
      for (std::size_t s = 0; s < sites_.size(); ++s) {
        if (!sites_[s]->has(i)) continue;
        if (first == sites_.size()) first = s;
        if (bodies[i].site == sites_.size() && sites_[s]->decides(i)) bodies[i].site = s;
      }
      if (first == sites_.size()) {
        ++lost_;
        continue;
      }
      if (bodies[i].site == sites_.size()) {
        ++missing_;
        bodies[i].site = first;
      }
      bodies[i].pose = sites_[bodies[i].site]->pose(i);
    }
    return bodies;
  }

  /// Everybody tells the first peer where the bodies are; it cuts anew and tells where. Whoever
  /// hears that goes by it from then on: for a while borders overlap or leave gaps.
  void balance(int step) {
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      consensus::Transport& transport = control_.transport(s + 1);
      std::vector<consensus::Packet> packets;
      transport.drain(packets);
      for (const consensus::Packet& packet : packets) {
        if (s == 0) {
          told_[packet.from - 1] = points_of(packet);
        } else {
          sites_[s]->set_cells(cells_for(points_of(packet), sites_.size()));
        }
      }
      if (s > 0 && step % kBalanceEvery == 0) {
        transport.post(1, bytes_of(sites_[s]->decided()), consensus::Delivery::Reliable);
      }
    }
    if (step % kBalanceEvery != kBalanceEvery / 2) return;
    told_[0] = sites_[0]->decided();
    std::vector<Vec3> all;
    for (const auto& points : told_) {
      if (points.empty()) return;
      all.insert(all.end(), points.begin(), points.end());
    }
    sites_[0]->set_cells(cells_for(all, sites_.size()));
    for (std::size_t s = 1; s < sites_.size(); ++s) {
      control_.transport(1).post(s + 1, bytes_of(all), consensus::Delivery::Reliable);
    }
  }

  void sample() {
    const std::vector<Known> bodies = known();
    const demos::Scene& scene = sites_[0]->scene();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i].site == sites_.size()) continue;
      order.push_back(i);
      const Vec3& p = bodies[i].pose.position;
      const double low = scene.bodies[i].half_extents.minCoeff();
      const double deep = options_.which == Which::Cliff
                              ? low - (p.z() - demos::cliff_surface(p.x(), p.y()))
                              : demos::ground_overlap(bodies[i].pose, scene.bodies[i].half_extents);
      if (deep > 0.0) ground_.add(deep);
      if (deep > low) ++under_;
      for (std::size_t s = 0; s < sites_.size(); ++s) {
        if (s == bodies[i].site || !sites_[s]->has(i)) continue;
        apart_.add((sites_[s]->pose(i).position - p).norm());
      }
    }
    const auto reach = [&](std::size_t i) { return scene.bodies[i].half_extents.norm(); };
    const auto low = [&](std::size_t i) { return bodies[i].pose.position.x() - reach(i); };
    std::sort(order.begin(), order.end(), [&](auto l, auto r) { return low(l) < low(r); });
    for (std::size_t a = 0; a < order.size(); ++a) {
      const std::size_t i = order[a];
      const double end = bodies[i].pose.position.x() + reach(i);
      for (std::size_t b = a + 1; b < order.size() && low(order[b]) < end; ++b) {
        const std::size_t j = order[b];
        const Vec3 between = bodies[i].pose.position - bodies[j].pose.position;
        if (between.norm() > reach(i) + reach(j)) continue;
        const double depth =
            overlap(scene.bodies[i], bodies[i].pose, scene.bodies[j], bodies[j].pose);
        if (depth > 0.0) (bodies[i].site == bodies[j].site ? inside_ : seam_).add(depth);
      }
    }
  }

  Options options_;
  consensus::VirtualNetwork network_;
  consensus::VirtualNetwork control_;    ///< of the same latency
  std::vector<std::vector<Vec3>> told_;  ///< m, where each peer's bodies were, as the first knows
  std::vector<std::unique_ptr<Site>> sites_;
  std::vector<std::vector<double>> cpu_;  ///< s, by site and step
  Sample apart_, inside_, seam_, ground_;
  std::size_t lost_ = 0;     ///< bodies that no peer has
  std::size_t missing_ = 0;  ///< samples of bodies on which nobody decides
  std::size_t under_ = 0;    ///< samples of bodies whose middle is under the ground
};

}  // namespace

int main(int argc, char** argv) {
  return demos::program_main(argc, argv, kUsage, [](std::span<const std::string_view> words) {
    Run run(parse(words));
    run.run();
    demos::JsonWriter json;
    run.report(json);
    std::cout << json.text() << '\n';
    return 0;
  });
}
