// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/user.h"

namespace tandem::demos {

/// What a runner must know of a demo.
class Scenario {
 public:
  virtual ~Scenario() = default;
  virtual std::string name() const = 0;
  virtual Scene build(const SceneOptions& options) const = 0;

  /// How many users the script has; user u sits at peer u + 1, or at the last peer where there are
  /// fewer peers than users.
  virtual std::size_t user_count() const = 0;
  /// Both must outlive the user.
  virtual std::unique_ptr<User> make_user(std::size_t user, const Scene& scene,
                                          consensus::Peer& peer,
                                          const UserOptions& options) const = 0;

  /// What is wrong with a world at this moment that must never be; empty where nothing is.
  virtual std::string fault(const Scene& scene) const = 0;
};

}  // namespace tandem::demos
