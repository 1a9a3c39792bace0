// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Another engine as a full peer of a session. The scene's world is a view of Bullet's: what peers
// agree upon moves the view, the view moves Bullet before its step and follows it afterwards. So
// nothing of the consensus is written twice, and a peer is not asked what engine it has.
#include "benchmarks/engine/engine.h"
#include "bullet/bullet_scene.h"
#include "common/physics.h"

namespace tandem::demos {

namespace {

using pbd::Mat3;
using pbd::Vec3;

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// A user's spring over a step of `dt` s as an impulse, with stretch and speed as they will be at
/// its end: stable however stiff it is. (K = k dt^2 + c dt, f the force:
/// (1 + K W) f = k (e + dt e') + c e', W the inverse mass that the point feels.)
/// @param gravity  m/s^2, which the engine is going to add
void pull(const pbd::Tether::Def& spring, const pbd::BodyProps& props, const Vec3& gravity,
          double dt, pbd::BodyState& state) {
  const Mat3 turn = state.pose.orientation.toRotationMatrix();
  const Vec3 r = turn * spring.anchor_l;
  const Mat3 inverse_inertia = turn * props.inverse_inertia_l * turn.transpose();
  const Mat3 arm = cross_matrix(r);
  const Mat3 mobility = props.inverse_mass * Mat3::Identity() - arm * inverse_inertia * arm;
  const Vec3 stretch = spring.anchor_w - (state.pose.position + r);
  const Vec3 closing =
      spring.anchor_velocity - (state.twist.linear + dt * gravity + state.twist.angular.cross(r));
  const double gain = spring.stiffness * dt * dt + spring.damping * dt;
  const Vec3 wanted = spring.stiffness * (stretch + dt * closing) + spring.damping * closing;
  Vec3 force = (Mat3::Identity() + gain * mobility).partialPivLu().solve(wanted);
  const double strength = force.norm();
  if (strength > spring.max_force) force *= spring.max_force / strength;
  state.twist.linear += dt * props.inverse_mass * force;
  state.twist.angular += dt * (inverse_inertia * r.cross(force));
}

bool same(const pbd::Pose& a, const pbd::Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}
bool same(const pbd::Twist& a, const pbd::Twist& b) {
  return a.linear == b.linear && a.angular == b.angular;
}

bool finite(const pbd::BodyState& state) {
  return state.pose.position.allFinite() && state.pose.orientation.coeffs().allFinite() &&
         state.twist.linear.allFinite() && state.twist.angular.allFinite();
}

class BulletPhysics final : public Physics {
 public:
  BulletPhysics(const Scene& scene, std::optional<int> iterations)
      : plain_(plain_scene(scene)),
        engine_(bench::make_bullet(plain_.scene, {.iterations = iterations, .sleeping = true})) {
    for (const SceneBody& body : scene.bodies) seen_.push_back(scene.world->state(body.body));
  }

  const pbd::StepReport& step(Scene& scene, consensus::Peer& peer, double dt) override {
    springs_.clear();
    peer.springs(springs_);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) push(scene, i, dt);
    engine_->step(dt);
    report_.status = pbd::StepStatus::Ok;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) fetch(scene, i);
    note_contacts(scene, peer);
    return report_;
  }
  const std::vector<std::pair<std::size_t, std::size_t>>* touching() const override {
    return &touching_;
  }

 private:
  int index(std::size_t body) const { return plain_.index[body]; }

  /// What was done to the view since the last step is done to the engine: poses without a word to
  /// the velocity, velocities as they are.
  void push(const Scene& scene, std::size_t i, double dt) {
    const pbd::BodyId id = scene.bodies[i].body;
    const pbd::BodyState view = scene.world->state(id);
    if (!same(view.pose, seen_[i].pose)) engine_->set_pose(index(i), view.pose);
    pbd::BodyState pulled = view;
    for (const pbd::Tether::Def& spring : springs_) {
      if (spring.body == id)
        pull(spring, scene.world->props(id), scene.world->gravity(), dt, pulled);
    }
    if (!same(pulled.twist, seen_[i].twist)) engine_->set_twist(index(i), pulled.twist);
  }

  void fetch(Scene& scene, std::size_t i) {
    const pbd::BodyId id = scene.bodies[i].body;
    pbd::BodyState state = engine_->state(index(i));
    const pbd::AxisLocks& locks = scene.world->props(id).locks;
    // What is held up stays where the view has it.
    const bool held_up = locks.linear[0] && locks.linear[1] && locks.linear[2];
    if (held_up || !finite(state)) {
      if (!held_up) report_.status = pbd::StepStatus::NonFinite;
      state = {seen_[i].pose, {}};
      engine_->set_pose(index(i), state.pose);
      engine_->set_twist(index(i), state.twist);
    }
    scene.world->set_pose(id, state.pose);
    scene.world->set_twist(id, state.twist);
    seen_[i] = scene.world->state(id);
  }

  void note_contacts(const Scene& scene, consensus::Peer& peer) {
    pairs_.clear();
    touching_.clear();
    engine_->touching(pairs_);
    for (const auto& [a, b] : pairs_) {
      const int shared_a = plain_.shared[static_cast<std::size_t>(a)];
      const int shared_b = plain_.shared[static_cast<std::size_t>(b)];
      const auto body = [&](int shared) {
        return shared < 0 ? pbd::BodyId{} : scene.bodies[static_cast<std::size_t>(shared)].body;
      };
      peer.note_contact(body(shared_a), body(shared_b));
      if (shared_a < 0 || shared_b < 0) continue;
      touching_.emplace_back(static_cast<std::size_t>(shared_a),
                             static_cast<std::size_t>(shared_b));
    }
  }

  PlainScene plain_;
  std::unique_ptr<bench::Engine> engine_;
  std::vector<pbd::BodyState> seen_;  ///< of the view after the last step, by shared body
  pbd::StepReport report_;
  std::vector<std::pair<std::size_t, std::size_t>> touching_;
  // Scratch, kept for its capacity.
  std::vector<pbd::Tether::Def> springs_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace

bool has_bullet() { return true; }

std::unique_ptr<Physics> make_bullet_physics(const Scene& scene, std::optional<int> iterations) {
  return std::make_unique<BulletPhysics>(scene, iterations);
}

}  // namespace tandem::demos
