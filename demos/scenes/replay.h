// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <vector>

#include "scenes/controls.h"
#include "scenes/user.h"

namespace tandem::demos {

/// Does what was recorded.
class InputPlayer {
 public:
  /// Must outlive it.
  explicit InputPlayer(Controls& controls) : controls_(controls) {}
  /// Now. Springs have the numbers that they had when they were recorded.
  /// @pre the input's body is one of the scene's, its values keep their rules
  /// @throws as Controls
  void play(const Input& input);

 private:
  Controls& controls_;
  std::map<std::uint32_t, std::uint32_t> springs_;  ///< recorded number to live one
};

/// Does what another user was recorded to do, whatever it sees. With the same step times every
/// input comes in the step it was recorded in; else in the first step that begins later.
class ReplayUser final : public User {
 public:
  /// @param inputs  of any users, by time; those of `user` count
  ReplayUser(std::size_t user, std::span<const Input> inputs, Controls& controls);
  void update(consensus::SessionTime now) override;

 private:
  Controls& controls_;
  InputPlayer hands_;
  std::vector<Input> inputs_;
  std::size_t next_ = 0;
};

}  // namespace tandem::demos
