// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

// One fuzz target is one source file that defines these two. It is linked with libFuzzer where that
// is wanted, and with mutate.cpp, which needs no compiler's help, for the tests.

namespace fuzz {

using Bytes = std::vector<std::byte>;

/// Input of any length and content: it must come back.
void run(std::span<const std::byte> input);

/// Inputs that honest code writes, from which to start.
std::vector<Bytes> seeds();

/// What must hold whatever the input.
inline void require(bool holds) {
  if (!holds) std::abort();
}

/// Decisions taken from the input; zeros at its end.
class Choices {
 public:
  explicit Choices(std::span<const std::byte> input) : input_(input) {}

  bool done() const { return at_ >= input_.size(); }
  unsigned byte() { return done() ? 0 : static_cast<unsigned>(input_[at_++]); }
  std::uint64_t number(int bytes) {
    std::uint64_t out = 0;
    for (int i = 0; i < bytes; ++i) out |= std::uint64_t{byte()} << (8 * i);
    return out;
  }
  std::span<const std::byte> bytes(std::size_t count) {
    const auto out = input_.subspan(at_, std::min(count, input_.size() - at_));
    at_ += out.size();
    return out;
  }

 private:
  std::span<const std::byte> input_;
  std::size_t at_ = 0;
};

}  // namespace fuzz
