// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes/pointer_hand.h"
#include "scenes/scene.h"
#include "tandem/pbd/tether.h"
#include "tandem/scene_files.h"
#include "view/protocol.h"

namespace tandem::demos {

/// The world of a scene file as one pane of the live view, with hands of pages. Bodies of the pane
/// are those that move and have a shape; static ones are its fixed parts. Sensors are not shown.
/// @par Thread safety  One object: one thread at a time.
class FileWorld {
 public:
  /// @param ground  adds a ground at the lowest point of all shapes, unless there is a half-space
  explicit FileWorld(SceneFile file, bool ground = false);

  /// Names, shapes and fixed parts; it has no world.
  const Scene& description() const { return description_; }
  double time() const { return time_; }  ///< s
  /// m: no body is farther away from the origin, along any axis, at the start.
  double reach() const { return reach_; }

  void step(double dt);
  /// As at the start. All grips end.
  void restart();
  void show(view::PaneFrame& out, bool overlays) const;

  /// Holds a body at the point of its bounding box nearest to `point`.
  void grab(view::PageId page, const view::Grab& grab);
  void move(view::PageId page, const view::Move& move);
  void release(view::PageId page, std::uint32_t id);
  void leave(view::PageId page);

 private:
  struct Grip {
    view::PageId page = 0;
    std::uint32_t id = 0;
    std::size_t body = 0;  ///< index in the pane
    pbd::ConstraintId spring;
    PointerHand hand;
    pbd::Vec3 wanted_w = pbd::Vec3::Zero();  ///< m, target of the page
  };
  void describe();
  void add_ground();
  Grip* find(view::PageId page, std::uint32_t id);
  void show_springs(view::PaneFrame& out) const;

  SceneFile file_;
  Scene description_;
  BodiesBySlot shown_;
  pbd::Tethers* springs_ = nullptr;  ///< owned by the world
  std::vector<std::byte> start_;     ///< snapshot
  std::vector<Grip> grips_;
  double time_ = 0.0;
  double reach_ = 0.0;
  double step_s_ = 0.0;  ///< wall time of the last step
};

}  // namespace tandem::demos
