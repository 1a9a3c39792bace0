// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <vector>

#include "scenes/scene.h"
#include "session/track.h"

namespace tandem::demos {

/// Writes a run as binary glTF 2.0: static bodies, and a node per peer with all its bodies and
/// their motion; peers after the first are translucent. Samples on the line between their
/// neighbours (0.1 mm, 0.1 degrees) are left out.
/// @param scene  bodies and shapes of any peer
/// @throws std::runtime_error if the file cannot be written
void write_glb(const std::string& file, const Scene& scene, const std::vector<PeerRecord>& peers);

}  // namespace tandem::demos
