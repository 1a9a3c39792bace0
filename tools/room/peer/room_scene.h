// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tandem/scene.h"

namespace tandem::room {

/// A room's bodies by name, from its file (tools/room/page/room-NAME.json) and made by members.
class RoomScene {
 public:
  struct Body {
    std::string name;
    pbd::BodyId body;
    double mass = 0.0;  ///< kg; 0 = static
  };

  /// @param text  JSON @throws std::invalid_argument naming field, value and rule
  explicit RoomScene(std::string_view text);

  Scene& scene() { return scene_; }
  const std::vector<Body>& bodies() const { return bodies_; }
  const Body* find(std::string_view name) const;

  /// Adds a member's body. Untrusted: null if it is not allowed, or there are too many.
  /// @param text  JSON of one body
  const Body* make(std::string_view text);

 private:
  static constexpr std::size_t kMaxBodies = 320;

  Scene scene_;
  std::vector<Body> bodies_;
};

}  // namespace tandem::room
