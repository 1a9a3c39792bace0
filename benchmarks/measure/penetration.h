// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <vector>

#include "demos/engine/engine.h"
#include "measure/geometry.h"

namespace tandem::bench {

struct Penetration {
  double max = 0.0;   ///< m
  double mean = 0.0;  ///< m, over touching pairs; gaps count as 0
  int pairs = 0;      ///< with a gap below 5 mm
};

/// Measures overlap from the poses, the same for every engine: balls and boxes with each other,
/// with fixed boxes and with a surface.
class PenetrationProbe {
 public:
  explicit PenetrationProbe(const Scene& scene);
  Penetration measure(const Engine& engine);

 private:
  double pair_gap(std::size_t a, std::size_t b) const;

  const Scene& scene_;
  std::vector<std::size_t> moving_;
  std::vector<std::size_t> fixed_;  ///< boxes
  std::unique_ptr<HeightSurface> surface_;
  std::vector<Pose> poses_;      ///< by body
  std::vector<double> reaches_;  ///< m, by body: bounding radius
  std::vector<std::size_t> order_;
};

}  // namespace tandem::bench
