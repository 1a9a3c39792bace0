// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>

#include "session/geometry.h"

namespace tandem::cluster_tool {
namespace {

using pbd::Vec3;

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// m: penetration depth of two bodies with one shape each.
double overlap(const SceneBody& a, const pbd::Pose& at_a, const SceneBody& b,
               const pbd::Pose& at_b) {
  const auto* ball_a = std::get_if<collision::Sphere>(&a.colliders[0].shape);
  const auto* ball_b = std::get_if<collision::Sphere>(&b.colliders[0].shape);
  if (ball_a != nullptr && ball_b != nullptr) {
    return ball_a->radius + ball_b->radius - (at_a.position - at_b.position).norm();
  }
  if (ball_b != nullptr) return overlap(b, at_b, a, at_a);
  const Vec3& half_b = std::get<collision::Box>(b.colliders[0].shape).half_extents;
  if (ball_a != nullptr) {
    return demos::ball_box_overlap(at_a.position, ball_a->radius, at_b, half_b);
  }
  const Vec3& half_a = std::get<collision::Box>(a.colliders[0].shape).half_extents;
  return demos::box_overlap(at_a, half_a, at_b, half_b);
}

double radius_of(const SceneBody& body) {
  const auto* ball = std::get_if<collision::Sphere>(&body.colliders[0].shape);
  return ball != nullptr ? ball->radius
                         : std::get<collision::Box>(body.colliders[0].shape).half_extents.norm();
}

void write(demos::JsonWriter& json, std::string_view name, const std::vector<double>& values) {
  json.key(name).begin_object().field("samples", values.size());
  json.field("p50", quantile(values, 0.5)).field("p99", quantile(values, 0.99));
  json.field("max", quantile(values, 1.0)).end_object();
}

}  // namespace

Measures::Measures(mpi::Cluster& cluster, const Scene& scene)
    : cluster_(cluster), scene_(scene), rank_cpu_(static_cast<std::size_t>(cluster.count()), 0.0) {}

void Measures::note_step() {
  const mpi::StepCost& cost = cluster_.cost();
  const std::array<double, 4> own = {cost.cpu, cost.modelled, static_cast<double>(cost.messages),
                                     static_cast<double>(cost.bytes)};
  std::vector<double> all(own.size() * rank_cpu_.size());
  MPI_Gather(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(),
             static_cast<int>(own.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
  if (cluster_.rank() != 0) return;
  double slowest = 0.0, sum = 0.0, modelled = 0.0;
  for (std::size_t r = 0; r < rank_cpu_.size(); ++r) {
    const double* cpu = &all[own.size() * r];
    slowest = std::max(slowest, cpu[0]);
    sum += cpu[0];
    modelled = std::max(modelled, cpu[1]);
    rank_cpu_[r] += cpu[0];
    messages_ += static_cast<std::size_t>(cpu[2]);
    bytes_ += static_cast<std::size_t>(cpu[3]);
  }
  slowest_.push_back(slowest);
  mean_.push_back(sum / static_cast<double>(rank_cpu_.size()));
  modelled_.push_back(modelled);
}

std::vector<Measures::Body> Measures::gather_bodies() {
  std::vector<double> own;
  const pbd::World& world = cluster_.world();
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const pbd::BodyId body = world.body_at(slot);
    if (!body.valid() || !cluster_.owns(body)) continue;
    const pbd::Pose& pose = world.pose(body);
    const auto& q = pose.orientation.coeffs();
    own.insert(own.end(), {static_cast<double>(*world.props(body).stable_id), pose.position.x(),
                           pose.position.y(), pose.position.z(), q[0], q[1], q[2], q[3]});
  }
  const int size = static_cast<int>(own.size());
  std::vector<int> sizes(rank_cpu_.size());
  std::vector<int> places(rank_cpu_.size());
  MPI_Gather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::partial_sum(sizes.begin(), sizes.end() - 1, places.begin() + 1);
  std::vector<double> all;
  if (cluster_.rank() == 0) all.resize(static_cast<std::size_t>(places.back() + sizes.back()));
  MPI_Gatherv(own.data(), size, MPI_DOUBLE, all.data(), sizes.data(), places.data(), MPI_DOUBLE, 0,
              MPI_COMM_WORLD);
  std::vector<Body> bodies;
  if (cluster_.rank() != 0) return bodies;
  bodies.resize(scene_.bodies);
  for (int r = 0; r < cluster_.count(); ++r) {
    const auto rank = static_cast<std::size_t>(r);
    for (int at = places[rank]; at < places[rank] + sizes[rank]; at += 8) {
      const double* b = &all[static_cast<std::size_t>(at)];
      Body& body = bodies[static_cast<std::size_t>(b[0])];
      body.pose = {Vec3(b[1], b[2], b[3]), pbd::Quat(b[7], b[4], b[5], b[6])};
      body.rank = r;
    }
  }
  return bodies;
}

void Measures::find_overlaps(const std::vector<Body>& bodies) {
  std::vector<SceneBody> plans;
  std::vector<double> radii;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    plans.push_back(scene_.body(i));
    radii.push_back(radius_of(plans.back()));
  }
  std::vector<std::size_t> order(bodies.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto low = [&](std::size_t i) { return bodies[i].pose.position.x() - radii[i]; };
  std::sort(order.begin(), order.end(), [&](auto l, auto r) { return low(l) < low(r); });
  for (std::size_t a = 0; a < order.size(); ++a) {
    const std::size_t i = order[a];
    const double end = bodies[i].pose.position.x() + radii[i];
    for (std::size_t b = a + 1; b < order.size() && low(order[b]) < end; ++b) {
      const std::size_t j = order[b];
      const Vec3 between = bodies[i].pose.position - bodies[j].pose.position;
      if (between.norm() > radii[i] + radii[j]) continue;
      const double depth = overlap(plans[i], bodies[i].pose, plans[j], bodies[j].pose);
      if (depth > 0.0) (bodies[i].rank == bodies[j].rank ? inside_ : seam_).push_back(depth);
    }
  }
}

void Measures::sample(double time) {
  samples_.push_back({time, cluster_.totals()});
  const std::vector<Body> bodies = gather_bodies();
  if (cluster_.rank() != 0) return;
  find_overlaps(bodies);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Vec3 way = bodies[i].pose.position - scene_.body(i).def.pose.position;
    way.z() = 0.0;
    drift_ = std::max(drift_, way.norm());
  }
}

void Measures::write(demos::JsonWriter& json) const {
  json.field("steps", slowest_.size());
  json.field("slowest_rank_s", mean(slowest_)).field("mean_rank_s", mean(mean_));
  json.field("slowest_rank_p95_s", quantile(slowest_, 0.95));
  json.field("modelled_s", mean(modelled_));
  json.field("imbalance", mean(mean_) > 0.0 ? mean(slowest_) / mean(mean_) : 1.0);
  const double most = *std::max_element(rank_cpu_.begin(), rank_cpu_.end());
  const double sum = std::accumulate(rank_cpu_.begin(), rank_cpu_.end(), 0.0);
  json.field("busiest_rank_s",
             most / static_cast<double>(std::max<std::size_t>(1, slowest_.size())));
  json.field("imbalance_of_sums",
             sum > 0.0 ? most * static_cast<double>(rank_cpu_.size()) / sum : 1.0);
  const double count =
      static_cast<double>(std::max<std::size_t>(1, slowest_.size()) * rank_cpu_.size());
  json.field("messages_per_rank_and_step", static_cast<double>(messages_) / count);
  json.field("bytes_per_rank_and_step", static_cast<double>(bytes_) / count);
  cluster_tool::write(json, "inside_m", inside_);
  cluster_tool::write(json, "seam_m", seam_);
  json.field("drift_m", drift_);
  json.key("samples").begin_array();
  for (const Sample& sample : samples_) {
    const mpi::Totals& t = sample.totals;
    json.begin_object().field("time_s", sample.time).field("bodies", t.bodies);
    json.field("awake", t.awake).field("kinetic_J", t.kinetic_energy);
    json.field("mechanical_J", t.mechanical_energy);
    json.key("momentum_Ns").begin_array();
    for (int axis = 0; axis < 3; ++axis) json.value(t.momentum[axis]);
    json.end_array().field("hash", std::to_string(t.hash)).end_object();
  }
  json.end_array();
}

}  // namespace tandem::cluster_tool
