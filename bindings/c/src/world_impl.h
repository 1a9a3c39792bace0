// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "tandem/c/tandem.h"
#include "tandem/collision/contact_events.h"
#include "tandem/pbd/joint.h"
#include "tandem/scene.h"

/// All parts of a world of the C interface. Its functions are inline, since sessions and scene
/// files are in other libraries.
struct tandem_world {
  /// @param collects  whether contact events are collected
  tandem_world(std::shared_ptr<tandem::Scene> of, bool collects)
      : scene(std::move(of)),
        world(scene->world()),
        shapes(scene->shapes()),
        // Created at once: a snapshot only fits worlds with the same blocks.
        joints(scene->joints()) {
    if (collects) events.emplace();
  }

  const tandem::pbd::StepReport& step(double dt) {
    const tandem::pbd::StepReport& done = scene->step(dt);
    if (events) events->update(world, shapes);
    return done;
  }

  std::shared_ptr<tandem::Scene> scene;  ///< may be part of a loaded file
  tandem::pbd::World& world;
  tandem::collision::CollisionScene& shapes;
  tandem::pbd::JointBlock& joints;
  /// If collected. Not the scene's, as these can be restored.
  std::optional<tandem::collision::ContactEvents> events;
};

namespace tandem::c {

inline SceneOptions options_of(const tandem_world_def& def) {
  SceneOptions options;
  options.gravity = {def.gravity.x, def.gravity.y, def.gravity.z};
  options.solver.substeps = def.substeps;
  options.solver.sleep_after = def.sleep_after;
  options.solver.threads = def.threads;
  options.solver.measure_stages = false;
  return options;
}

}  // namespace tandem::c
