// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/physics.h"

namespace tandem::demos {

namespace {

class TandemPhysics final : public Physics {
 public:
  explicit TandemPhysics(const pbd::SolverOptions& options) : solver_(options) {}
  const pbd::StepReport& step(Scene& scene, consensus::Peer& /*peer*/, double dt) override {
    return solver_.step(*scene.world, dt);
  }

 private:
  pbd::Solver solver_;
};

}  // namespace

std::string_view to_string(Engine engine) { return engine == Engine::Tandem ? "tandem" : "bullet"; }

std::unique_ptr<Physics> make_physics(Engine engine, const Scene& scene,
                                      std::optional<int> iterations,
                                      const pbd::SolverOptions& solver) {
  if (engine == Engine::Bullet) return make_bullet_physics(scene, iterations);
  return std::make_unique<TandemPhysics>(solver);
}

}  // namespace tandem::demos
