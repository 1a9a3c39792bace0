// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::demos {

/// What one hand did in a room, as the room's page wrote it. The format is in docs/hands.md.
struct HandRecord {
  static constexpr double kLongest = 600.0;   ///< s
  static constexpr double kFarthest = 100.0;  ///< m, of each coordinate
  static constexpr int kMaxRate = 240;        ///< 1/s

  /// From a grab to its release.
  struct Hold {
    struct Point {
      double time = 0.0;                     ///< s since the record's start
      pbd::Vec3 wanted = pbd::Vec3::Zero();  ///< m, world: where the hand wants its body's point
    };
    std::string body;                            ///< its name in that room
    pbd::Vec3 attachment_l = pbd::Vec3::Zero();  ///< m, frame of the body
    std::vector<Point> way;                      ///< by time, the first is the grab; not empty
    double end = 0.0;                            ///< s, the release

    double start() const { return way.front().time; }
    /// Between two points on the line from one to the other.
    pbd::Vec3 wanted(double time) const;
  };
  std::string room;
  int rate = 60;            ///< 1/s, points at most
  double seconds = 0.0;     ///< s, its length
  std::vector<Hold> holds;  ///< by time, one after the other
};

/// @param file  as errors call it
/// @throws std::invalid_argument naming file, line, field, rule and value
HandRecord hand_record_from_text(std::string_view text, std::string_view file);
/// @throws std::runtime_error where it cannot be read @throws std::invalid_argument as above
HandRecord read_hand_record(const std::string& path);

}  // namespace tandem::demos
