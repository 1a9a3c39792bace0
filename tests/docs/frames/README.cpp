// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of README.md.

// page: Use it

#include <string>

#include "tandem/net/keys.h"

void play_sound(const Vec3& point, double speed);

void joints(Scene& scene, BodyId frame, BodyId door, const Vec3& hinge_point, const Vec3& eye) {
  // page: Use it, 2
}

void sharing(Scene& scene, BodyId cube, const net::Key& key, const net::Key& own_key,
             const net::Key& organiser, const std::vector<std::byte>& certificate) {
  // page: Use it, 3
}
