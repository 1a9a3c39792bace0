// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <vector>

#include "scenes/scene.h"
#include "session/track.h"

namespace tandem::demos {

/// Writes a run as binary glTF 2.0: what is fixed, and for each peer a node with all its bodies and
/// their motion; peers after the first are translucent, so that they can be seen through each
/// other. Samples that lie on the line between their neighbours (0.1 mm, 0.1 degrees) are left out.
/// @param scene  bodies and shapes, as any peer has them
/// @throws std::runtime_error where the file cannot be written
void write_glb(const std::string& file, const Scene& scene, const std::vector<PeerRecord>& peers);

}  // namespace tandem::demos
