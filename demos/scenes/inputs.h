// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// One user input in one step.
struct Input {
  enum class Kind : std::uint8_t {
    Grab,     ///< object: spring; body; values: attachment_l, anchor_w, stiffness, damping, force
    Hold,     ///< the same, unknown to other peers
    Move,     ///< object: spring; values: anchor_w
    Release,  ///< object: spring
    Drive,    ///< object: body; values: position, orientation x y z w, at the end of the step
    Jump,     ///< object: body; values: position, orientation
    Signal,   ///< object: code; values: s from this input to the signal's time
  };
  std::uint32_t user = 0;
  consensus::SessionTime time = 0;  ///< ns since the epoch
  Kind kind = Kind::Move;
  std::uint32_t object = 0;
  std::uint32_t body = 0;      ///< index into Scene::bodies
  std::vector<double> values;  ///< by kind, in m, N/m, N s/m, N
};

std::size_t value_count(Input::Kind kind);
/// The rule that the values break; empty if they are valid.
std::string_view broken_rule(const Input& input);

/// One line per input, numbers with every bit.
std::string inputs_to_text(std::span<const Input> inputs);
/// @throws std::invalid_argument naming line and rule
std::vector<Input> inputs_from_text(const std::string& text);

}  // namespace tandem::demos
