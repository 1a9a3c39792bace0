// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <vector>

#include "scenes/controls.h"
#include "scenes/user.h"

namespace tandem::demos {

class InputPlayer {
 public:
  /// Must outlive it.
  explicit InputPlayer(Controls& controls) : controls_(controls) {}
  /// Plays an input now. Springs are named by their recorded numbers.
  /// @pre the input's body is in the scene, its values are valid
  /// @throws as Controls
  void play(const Input& input);

 private:
  Controls& controls_;
  std::map<std::uint32_t, std::uint32_t> springs_;  ///< recorded number to live one
};

/// Replays another user's inputs. With the same step times each input comes in its recorded step;
/// otherwise in the first step that begins later.
class ReplayUser final : public User {
 public:
  /// @param inputs  of any users, by time; only those of `user` are played
  ReplayUser(std::size_t user, std::span<const Input> inputs, Controls& controls);
  void update(consensus::SessionTime now) override;

 private:
  Controls& controls_;
  InputPlayer hands_;
  std::vector<Input> inputs_;
  std::size_t next_ = 0;
};

}  // namespace tandem::demos
