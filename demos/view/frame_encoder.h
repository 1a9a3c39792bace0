// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "view/protocol.h"

namespace tandem::demos::view {

/// Encodes frames for pages, each once for all pages. demos/view/README.md has the format.
/// @par Thread safety  One object: one thread at a time. Returned bytes are immutable.
class FrameEncoder {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  explicit FrameEncoder(const Layout& layout);

  /// Takes the next frame and compares it with the last one.
  /// @param always  false: an unchanged frame is dropped
  /// @return whether it was taken
  /// @pre as many poses in each pane as the layout has bodies
  bool take(const Frame& frame, bool always);
  /// Number of the last frame, from 1; 0 = there was none.
  std::uint32_t number() const { return number_; }
  /// Restarts: after a time without pages, the last frame is out of date.
  void forget() { number_ = 0; }
  /// The last frame, or its changes since the one before. Overlays are included if wanted and
  /// known. @pre number() > 0
  Bytes bytes(bool key, bool overlays);

 private:
  struct Record {
    std::uint32_t low = 0;
    std::uint32_t high = 0;  ///< without the bit that announces another word
    std::uint32_t turn = 0;
    friend bool operator==(const Record&, const Record&) = default;
  };
  enum Change : std::uint8_t { kMoved = 1, kTurned = 2 };

  Record record_of(const pbd::Pose& pose, bool turns) const;
  Bytes write(bool key, bool overlays) const;

  double position_unit_;
  std::vector<std::uint8_t> turns_;  ///< 1: its rotation is visible
  std::uint32_t number_ = 0;
  Frame frame_;
  std::vector<Record> records_;        ///< by pane
  std::vector<std::uint8_t> changes_;  ///< since the frame before, by pane
  std::vector<Record> next_;
  std::array<Bytes, 4> written_;  ///< by (key, overlays), on demand
};

}  // namespace tandem::demos::view
