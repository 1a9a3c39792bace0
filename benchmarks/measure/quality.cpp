// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measure/quality.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "measure/clock.h"
#include "scenes/joint_scenes.h"

namespace tandem::bench {
namespace {

bool moves(const SceneBody& body) { return body.type == BodyType::Dynamic; }

double across(const Vec3& a, const Vec3& b) { return (a - b).head<2>().norm(); }

}  // namespace

double kinetic_energy(const Scene& scene, const Engine& engine) {
  double sum = 0.0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (!moves(body)) continue;
    const pbd::BodyState state = engine.state(static_cast<int>(i));
    const Vec3 w_l = state.pose.orientation.conjugate() * state.twist.angular;
    sum += 0.5 * body.mass * state.twist.linear.squaredNorm() +
           0.5 * w_l.dot(body.inertia.cwiseProduct(w_l));
  }
  return sum;
}

double mechanical_energy(const Scene& scene, const Engine& engine) {
  double sum = kinetic_energy(scene, engine);
  const double half_step = 0.5 * scene.dt / std::max(1, engine.stats().substeps);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!moves(scene.bodies[i])) continue;
    const pbd::BodyState state = engine.state(static_cast<int>(i));
    sum -= scene.bodies[i].mass *
           scene.gravity.dot(state.pose.position - half_step * state.twist.linear);
  }
  return sum;
}

std::vector<double> joint_separations(const Scene& scene, const Engine& engine) {
  std::vector<double> all;
  for (const SceneJoint& joint : scene.joints) {
    if (joint.kind != JointKind::Ball && joint.kind != JointKind::Hinge) continue;
    const Vec3 a =
        joint.a < 0 ? joint.anchor_a_l : engine.state(joint.a).pose.to_world(joint.anchor_a_l);
    const Vec3 b = engine.state(joint.b).pose.to_world(joint.anchor_b_l);
    all.push_back((a - b).norm());
  }
  return all;
}

double joint_separation(const Scene& scene, const Engine& engine) {
  const std::vector<double> all = joint_separations(scene, engine);
  return all.empty() ? 0.0 : *std::max_element(all.begin(), all.end());
}

/// Measures of one kind of scene beyond overlap and energy.
class Quality::Watch {
 public:
  explicit Watch(const Scene& scene) : scene_(scene) {}
  virtual ~Watch() = default;
  virtual void after_frame(int frame, const Engine& engine) = 0;
  virtual void finish(const Engine& engine, Measures& out) = 0;

 protected:
  Vec3 position(const Engine& engine, std::size_t body) const {
    return engine.state(static_cast<int>(body)).pose.position;
  }
  const Vec3& start(std::size_t body) const { return scene_.bodies[body].pose.position; }
  const Scene& scene_;
};

/// Ten stacks, the top layer is the last ten bodies.
class Quality::StackWatch final : public Watch {
 public:
  using Watch::Watch;
  void after_frame(int /*frame*/, const Engine& engine) override {
    drift_ = 0.0;
    sink_ = 0.0;
    fallen_ = 0;
    for (std::size_t i = scene_.bodies.size() - 10; i < scene_.bodies.size(); ++i) {
      const Vec3 p = position(engine, i);
      drift_ = std::max(drift_, across(p, start(i)));
      sink_ = std::max(sink_, start(i).z() - p.z());
      fallen_ += (p - start(i)).norm() > 0.5 && start(i).z() - p.z() > 0.5 ? 1 : 0;
    }
    drift_max_ = std::max(drift_max_, drift_);
  }
  void finish(const Engine& /*engine*/, Measures& out) override {
    out.emplace_back("drift_end", drift_);
    out.emplace_back("drift_max", drift_max_);
    out.emplace_back("sink_end", sink_);
    out.emplace_back("fallen", fallen_);
  }

 private:
  double drift_ = 0.0, drift_max_ = 0.0, sink_ = 0.0;
  int fallen_ = 0;
};

class Quality::PyramidWatch final : public Watch {
 public:
  using Watch::Watch;
  void after_frame(int /*frame*/, const Engine& engine) override {
    drift_ = 0.0;
    sink_ = 0.0;
    for (std::size_t i = 1; i < scene_.bodies.size(); ++i) {
      const Vec3 p = position(engine, i);
      drift_ = std::max(drift_, across(p, start(i)));
      sink_ = std::max(sink_, start(i).z() - p.z());
    }
    drift_max_ = std::max(drift_max_, drift_);
  }
  void finish(const Engine& /*engine*/, Measures& out) override {
    out.emplace_back("drift_end", drift_);
    out.emplace_back("drift_max", drift_max_);
    out.emplace_back("sink_end", sink_);
  }

 private:
  double drift_ = 0.0, drift_max_ = 0.0, sink_ = 0.0;
};

class Quality::RatioWatch final : public Watch {
 public:
  using Watch::Watch;
  void after_frame(int /*frame*/, const Engine& /*engine*/) override {}
  void finish(const Engine& engine, Measures& out) override {
    const std::size_t top = scene_.bodies.size() - 1;
    const Vec3 p = position(engine, top);
    const double lateral = across(p, start(top));
    const double height = p.z() - start(top).z();
    out.emplace_back("top_z_error", height);
    out.emplace_back("top_lateral", lateral);
    out.emplace_back("top_error", std::abs(height) + lateral);
    out.emplace_back("fell", (p - start(top)).norm() > 0.5 ? 1 : 0);
  }
};

class Quality::ChainWatch final : public Watch {
 public:
  ChainWatch(const Scene& scene, const Engine& engine, std::vector<Vec3> reference)
      : Watch(scene),
        reference_(std::move(reference)),
        energy_start_(mechanical_energy(scene, engine)) {
    double mass = 0.0;
    for (const SceneBody& body : scene.bodies) mass += body.mass;
    energy_unit_ = mass * scene.gravity.norm() * 10.0;
  }
  void after_frame(int frame, const Engine& engine) override {
    const double separation = joint_separation(scene_, engine);
    separation_max_ = std::max(separation_max_, separation);
    if (frame >= scene_.frames() - std::lround(1.0 / scene_.dt)) {
      separation_last_ += separation;
      ++count_last_;
    }
    drift_ = (mechanical_energy(scene_, engine) - energy_start_) / energy_unit_;
    if (std::abs(drift_) > std::abs(drift_max_)) drift_max_ = drift_;
    if (static_cast<std::size_t>(frame) < reference_.size()) {
      const Vec3 ball = position(engine, scene_.bodies.size() - 1);
      error_ = (ball - reference_[static_cast<std::size_t>(frame)]).norm();
      error_max_ = std::max(error_max_, error_);
    }
  }
  void finish(const Engine& /*engine*/, Measures& out) override {
    out.emplace_back("separation_max", separation_max_);
    out.emplace_back("separation_last_second", separation_last_ / std::max(1, count_last_));
    out.emplace_back("ball_error_max", error_max_);
    out.emplace_back("ball_error_end", error_);
    out.emplace_back("energy_drift_end", drift_);  // of M g L
    out.emplace_back("energy_drift_max", drift_max_);
  }

 private:
  std::vector<Vec3> reference_;
  double energy_start_ = 0.0, energy_unit_ = 1.0;
  double separation_max_ = 0.0, separation_last_ = 0.0;
  double error_ = 0.0, error_max_ = 0.0, drift_ = 0.0, drift_max_ = 0.0;
  int count_last_ = 0;
};

class Quality::CliffWatch final : public Watch {
 public:
  explicit CliffWatch(const Scene& scene)
      : Watch(scene),
        surface_(*std::get<MeshShape>(scene.bodies.front().shape)),
        tunnelled_(scene.bodies.size(), 0) {}
  void after_frame(int /*frame*/, const Engine& engine) override {
    left_ = 0;
    for (std::size_t i = 1; i < scene_.bodies.size(); ++i) {
      const Vec3 p = position(engine, i);
      const auto height = surface_.height(p.x(), p.y());
      if (!height) {
        ++left_;
        continue;
      }
      const double below = *height - p.z();
      if (below > 0.15 && below < 6.0) tunnelled_[i] = 1;
    }
  }
  void finish(const Engine& /*engine*/, Measures& out) override {
    out.emplace_back("left_mesh", left_);
    out.emplace_back("tunnelled",
                     static_cast<double>(std::count(tunnelled_.begin(), tunnelled_.end(), 1)));
  }

 private:
  HeightSurface surface_;
  std::vector<char> tunnelled_;
  int left_ = 0;
};

/// Heap and katamari: the pile's height shows whether it has come down.
class Quality::HeapWatch final : public Watch {
 public:
  using Watch::Watch;
  void after_frame(int /*frame*/, const Engine& /*engine*/) override {}
  void finish(const Engine& engine, Measures& out) override {
    double height = 0.0;
    int moving = 0;
    int escaped = 0;
    const bool walls = scene_.name == "heap";
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (!moves(scene_.bodies[i])) continue;
      const Vec3 p = position(engine, i);
      ++moving;
      height += p.z();
      const bool beyond = walls && p.head<2>().cwiseAbs().maxCoeff() > 5.0;
      escaped += beyond || p.z() < 0.0 ? 1 : 0;
    }
    out.emplace_back("mean_z", height / moving);
    out.emplace_back("escaped", escaped);
  }
};

/// Scenes of joints: gaps, change of energy, and sleep.
class Quality::JointWatch final : public Watch {
 public:
  JointWatch(const Scene& scene, const Engine& engine)
      : Watch(scene), start_(mechanical_energy(scene, engine)), now_(start_), most_(start_) {}
  void after_frame(int frame, const Engine& engine) override {
    const std::vector<double> apart = joint_separations(scene_, engine);
    separations_.insert(separations_.end(), apart.begin(), apart.end());
    const double before = now_;
    now_ = mechanical_energy(scene_, engine);
    most_ = std::max(most_, now_);
    rise_ = std::max(rise_, now_ - before);
    failed_ += engine.stats().failed ? 1 : 0;
    awake_ = 0;
    lowest_ = HUGE_VAL;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (!moves(scene_.bodies[i])) continue;
      awake_ += engine.awake(static_cast<int>(i)) ? 1 : 0;
      lowest_ = std::min(lowest_, position(engine, i).z());
    }
    if (awake_ > 0) frames_awake_ = frame + 1;
  }
  void finish(const Engine& /*engine*/, Measures& out) override {
    out.emplace_back("separation_p50", quantile(separations_, 0.5));
    out.emplace_back("separation_p99", quantile(separations_, 0.99));
    out.emplace_back("separation_max", quantile(separations_, 1.0));
    out.emplace_back("energy_start", start_);
    out.emplace_back("energy_end", now_);
    out.emplace_back("energy_max", most_);
    out.emplace_back("energy_rise_max", rise_);  // in one frame
    out.emplace_back("bodies", std::count_if(scene_.bodies.begin(), scene_.bodies.end(), moves));
    out.emplace_back("joints", scene_.joints.size());
    out.emplace_back("awake_end", awake_);
    out.emplace_back("frames_awake", frames_awake_);
    out.emplace_back("failed_steps", failed_);
    out.emplace_back("lowest_end", lowest_);
  }

 private:
  std::vector<double> separations_;  ///< of all joints in all frames
  double start_, now_, most_, rise_ = 0.0, lowest_ = 0.0;
  int awake_ = 0, frames_awake_ = 0, failed_ = 0;
};

Quality::Quality(const Scene& scene, const Engine& engine, std::vector<Vec3> reference)
    : scene_(scene) {
  if (scene.joints.empty()) probe_ = std::make_unique<PenetrationProbe>(scene);
  if (scene.name == "stacks") watch_ = std::make_unique<StackWatch>(scene);
  if (scene.name == "pyramid") watch_ = std::make_unique<PyramidWatch>(scene);
  if (scene.name == "ratio") watch_ = std::make_unique<RatioWatch>(scene);
  if (scene.name == "cliff") watch_ = std::make_unique<CliffWatch>(scene);
  if (scene.name == "heap" || scene.name == "katamari") watch_ = std::make_unique<HeapWatch>(scene);
  if (is_joint_scene(scene.name)) watch_ = std::make_unique<JointWatch>(scene, engine);
  if (scene.name == "chain") {
    watch_ = std::make_unique<ChainWatch>(scene, engine, std::move(reference));
  }
}

Quality::~Quality() = default;

void Quality::after_frame(int frame, const Engine& engine) {
  const int every = scene_.name == "heap" ? 30 : 10;
  if (probe_ != nullptr && frame % every == every - 1) {
    deepest_ = std::max(deepest_, probe_->measure(engine).max);
  }
  if (frame >= scene_.frames() - std::lround(1.0 / scene_.dt)) {
    max_kinetic_last_second_ = std::max(max_kinetic_last_second_, kinetic_energy(scene_, engine));
  }
  if (watch_ != nullptr) watch_->after_frame(frame, engine);
}

Measures Quality::finish(const Engine& engine) {
  Measures out;
  if (watch_ != nullptr) watch_->finish(engine, out);
  if (probe_ != nullptr) {
    const Penetration end = probe_->measure(engine);
    out.emplace_back("penetration_mean_end", end.mean);
    out.emplace_back("penetration_max_end", end.max);
    out.emplace_back("penetration_max_run", std::max(deepest_, end.max));
    out.emplace_back("touching_pairs", end.pairs);
  }
  out.emplace_back("kinetic_max_last_second", max_kinetic_last_second_);
  return out;
}

std::vector<Vec3> read_reference(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<Vec3> positions;
  double t = 0.0;
  for (Vec3 p; file >> t >> p.x() >> p.y() >> p.z();) positions.push_back(p);
  return positions;
}

}  // namespace tandem::bench
