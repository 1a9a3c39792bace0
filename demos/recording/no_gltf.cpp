// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "recording/gltf.h"

namespace tandem::demos {

void write_glb(const std::string& file, const Scene& /*scene*/,
               const std::vector<PeerRecord>& /*peers*/) {
  throw std::runtime_error(file + ": glTF needs a build with tinygltf (Debian: libtinygltf-dev)");
}

}  // namespace tandem::demos
