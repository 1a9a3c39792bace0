// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of docs/parts.md.
#include <fstream>

#include "tandem/pbd/solver.h"
#include "tandem/pbd/stage_observer.h"
#include "tandem/scene.h"

using namespace tandem;

void character(Scene& scene, bool button, double dt) {
  // page: A character
}

void car(Scene& scene) {
  // page: A car
}

void ragdoll(Scene& scene, const Pose& hero_feet) {
  // page: A ragdoll
}

void joints(Scene& scene, BodyId frame, BodyId leaf, const Vec3& corner, BodyId torso, BodyId head,
            const Vec3& throat, const Quat& look, BodyId hand, BodyId sword) {
  // page: Springs, motors and friction of joints
}

void cloth(Scene& scene, const Vec3& hook, const Vec3& top_of_crate, BodyId ceiling, BodyId crate,
           const Pose& corner, BodyId pole) {
  // page: Cloth and ropes
}

void trace() {
  // page: Where a step's time goes
}
