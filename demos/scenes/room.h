// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// Two users in a room, after [friston] Sec. 5.2. A stands at -x, B at +x. Furniture: two static
/// tables, a static shelf, a bench that takes two to carry. On the tables: "toy/box", "toy/hull",
/// "toy/cylinder" and "block/0" to "block/3". Avatars: see Person.
///
/// A hands the box to B, who puts it on the other table; both carry the bench; B stacks blocks on
/// the box while A throws the cylinder across the room and puts the hull on the shelf.
class RoomScenario final : public Scenario {
 public:
  static constexpr double kTable = 0.75;  ///< m
  static constexpr double kShelf = 1.1;   ///< m
  static constexpr double kBlock = 0.1;   ///< m, edge
  static constexpr double kBox = 0.12;    ///< m, edge
  static constexpr double kBench = 0.45;  ///< m, height

  RoomScenario() : Scenario("room", 2) {}

  Scene build(const SceneOptions& options) const override;
  std::unique_ptr<User> make_user(std::size_t user, Controls& controls,
                                  const UserOptions& options) const override;
  Bounds bounds() const override { return {.max_distance = 6.0, .max_speed = 15.0, .lowest = 0.0}; }
  std::vector<std::size_t> holdable(const Scene& scene) const override { return unowned(scene); }
  std::unique_ptr<Referee> make_referee(const Scene& scene) const override;
  Achievement achievement(const Outcome& outcome) const override;
};

}  // namespace tandem::demos
