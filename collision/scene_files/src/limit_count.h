// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <string>

#include "tandem/collision/crowding.h"
#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

/// Counts what a document has made against its limits.
class LimitCount {
 public:
  explicit LimitCount(const SceneLimits& most = {}) : most_(most) {}

  /// @return the rule if it is exceeded now, else an empty text
  std::string add(std::size_t SceneLimits::*what, std::size_t count = 1) {
    std::size_t& used = used_.*what;
    used += count;
    return used <= most_.*what ? std::string() : rule(what);
  }
  /// Checks the limit of colliders of one body.
  std::string parts(std::size_t count) const {
    return count <= most_.parts ? std::string() : rule(&SceneLimits::parts);
  }
  /// Checks the limit of pairs at the start.
  std::string pairs(Scene& scene) const {
    const bool crowded = collision::is_crowded(scene.shapes(), scene.world(), most_.pairs);
    return crowded ? rule(&SceneLimits::pairs) : std::string();
  }

 private:
  std::string rule(std::size_t SceneLimits::*what) const {
    struct Name {
      std::size_t SceneLimits::*what;
      const char* field;
      const char* words;
    };
    constexpr Name kNames[] = {
        {&SceneLimits::nodes, "nodes", "nodes"},
        {&SceneLimits::bodies, "bodies", "bodies"},
        {&SceneLimits::colliders, "colliders", "colliders"},
        {&SceneLimits::parts, "parts", "colliders of one body"},
        {&SceneLimits::joints, "joints", "joints"},
        {&SceneLimits::points, "points", "points of meshes and height fields"},
        {&SceneLimits::hull_points, "hull_points", "points to make hulls of"},
        {&SceneLimits::triangles, "triangles", "triangles"},
        {&SceneLimits::pairs, "pairs", "pairs of colliders that are close as the scene begins"}};
    for (const Name& each : kNames) {
      if (each.what != what) continue;
      return "of a scene with at most " + std::to_string(most_.*what) + ' ' + each.words +
             " (SceneLimits::" + each.field + ")";
    }
    return {};
  }

  SceneLimits most_;
  SceneLimits used_{.nodes = 0,
                    .bodies = 0,
                    .colliders = 0,
                    .parts = 0,
                    .joints = 0,
                    .points = 0,
                    .hull_points = 0,
                    .triangles = 0,
                    .pairs = 0};
};

/// @throws SceneFileError  if `rule` is not empty. @param where  the offending place
inline void require_within(const std::string& where, const std::string& rule) {
  if (!rule.empty()) throw SceneFileError(pbd::detail::must_be(where, rule));
}

}  // namespace tandem::scene_files
