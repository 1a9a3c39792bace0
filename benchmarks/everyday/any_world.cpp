// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "everyday/any_world.h"

namespace tandem::everyday {
namespace {

SceneOptions scene_options(const WorldOptions& options) {
  SceneOptions made{.gravity = options.gravity};
  if (!options.sleeping) made.solver.sleep_after = 0.0;
  return made;
}

class TandemWorld final : public AnyWorld {
 public:
  explicit TandemWorld(const WorldOptions& options) : scene_(scene_options(options)) {}

  BodyId add(std::span<const collision::CompoundPart> parts, const SolidDef& def) override {
    return parts.size() == 1 ? scene_.add(parts.front().shape, def) : scene_.add(parts, def);
  }
  void add_hinge(BodyId body, const Vec3& point_w, const Vec3& axis_w) override {
    scene_.add_joint(pbd::hinge_joint_at(scene_.world(), BodyId{}, body, point_w, axis_w));
  }
  void step(double dt) override { scene_.step(dt); }
  Pose pose(BodyId body) const override { return scene_.pose(body); }
  pbd::Twist twist(BodyId body) const override { return scene_.world().twist(body); }
  bool awake(BodyId body) const override { return scene_.world().awake(body); }
  double kinetic_energy() const override { return scene_.world().kinetic_energy(); }
  double mechanical_energy() const override { return scene_.world().mechanical_energy(); }

 private:
  Scene scene_;
};

}  // namespace

BodyId AnyWorld::add(const collision::Shape& shape, const SolidDef& def) {
  const collision::CompoundPart part{.shape = shape, .density = def.density};
  return add(std::span(&part, 1), def);
}

std::unique_ptr<AnyWorld> make_world(const bench::MakeEngine& peer, const WorldOptions& options) {
  if (peer) return make_peer_world(peer, options);
  return std::make_unique<TandemWorld>(options);
}

}  // namespace tandem::everyday
