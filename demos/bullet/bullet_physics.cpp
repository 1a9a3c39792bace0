// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Another engine as a full peer. The scene's world mirrors Bullet's: agreement moves the mirror,
// its changes are applied to Bullet before the step, and the mirror follows the result. So
// consensus needs no second implementation, and peers need not know each other's engine.
#include "bullet/bullet_scene.h"
#include "bullet/springs.h"
#include "demos/engine/engine.h"
#include "session/physics.h"

namespace tandem::demos {

namespace {

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
    for (const SceneBody& body : scene.bodies) {
      seen_.push_back(scene.world->state(body.body));
      pulls_.emplace_back().start(scene.world->gravity());
    }
    pushed_ = seen_;
  }

  const pbd::StepReport& step(Scene& scene, consensus::Peer& peer, double dt) override {
    all_springs_.clear();
    peer.springs(all_springs_);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) push(scene, i, dt);
    engine_->step(dt);
    report_.status = pbd::StepStatus::Ok;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) fetch(scene, i, dt);
    note_contacts(scene, peer);
    return report_;
  }
  const std::vector<std::pair<std::size_t, std::size_t>>* touching() const override {
    return &touching_;
  }

 private:
  int index(std::size_t body) const { return plain_.index[body]; }

  /// Applies the mirror's changes since the last step: poses without changing velocity, velocities
  /// as they are.
  void push(const Scene& scene, std::size_t i, double dt) {
    const pbd::BodyId id = scene.bodies[i].body;
    const pbd::BodyState& view = scene.world->state(id);
    if (!same(view.pose, seen_[i].pose)) engine_->set_pose(index(i), view.pose);
    springs_.clear();
    for (const pbd::Tether::Def& spring : all_springs_) {
      if (spring.body == id) springs_.push_back(spring);
    }
    pushed_[i] = view;
    if (!springs_.empty()) pulls_[i].pull(springs_, scene.world->props(id), dt, pushed_[i]);
    if (!same(pushed_[i].twist, seen_[i].twist)) engine_->set_twist(index(i), pushed_[i].twist);
  }

  void fetch(Scene& scene, std::size_t i, double dt) {
    const pbd::BodyId id = scene.bodies[i].body;
    pbd::BodyState state = engine_->state(index(i));
    const pbd::AxisLocks& locks = scene.world->props(id).locks;
    // Bodies locked in place stay where the mirror has them.
    const bool held_up = locks.linear[0] && locks.linear[1] && locks.linear[2];
    if (held_up || !finite(state)) {
      if (!held_up) report_.status = pbd::StepStatus::NonFinite;
      state = {seen_[i].pose, {}};
      engine_->set_pose(index(i), state.pose);
      engine_->set_twist(index(i), state.twist);
    }
    pulls_[i].learn(pushed_[i].twist, state.twist, dt);
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
  std::vector<pbd::BodyState> seen_;    ///< of the mirror after the last step, by shared body
  std::vector<pbd::BodyState> pushed_;  ///< given to the engine
  std::vector<SpringPulls> pulls_;
  pbd::StepReport report_;
  std::vector<std::pair<std::size_t, std::size_t>> touching_;
  // Scratch, kept for its capacity.
  std::vector<pbd::Tether::Def> all_springs_, springs_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace

bool has_bullet() { return true; }

std::unique_ptr<Physics> make_bullet_physics(const Scene& scene, std::optional<int> iterations) {
  return std::make_unique<BulletPhysics>(scene, iterations);
}

}  // namespace tandem::demos
