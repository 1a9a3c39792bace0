// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>

#include "tandem/c/tandem.h"
#include "tandem/collision/contact_events.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

/// All that a world of the C interface is made of.
struct tandem_world {
  explicit tandem_world(const tandem_world_def& def);

  /// Inline, since sessions are in another library.
  const tandem::pbd::StepReport& step(double dt) {
    const tandem::pbd::StepReport& done = solver.step(world, dt);
    if (events) events->update(world, scene);
    return done;
  }

  tandem::pbd::World world;
  tandem::collision::CollisionScene scene;
  tandem::pbd::JointBlock& joints;
  tandem::pbd::Solver solver;
  std::optional<tandem::collision::ContactEvents> events;  ///< where they are wanted
};
