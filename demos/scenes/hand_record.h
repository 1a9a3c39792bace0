// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::demos {

/// The motion of one hand in a room, recorded by the room's page. The format is in docs/hands.md.
struct HandRecord {
  static constexpr double kLongest = 600.0;   ///< s
  static constexpr double kFarthest = 100.0;  ///< m, of each coordinate
  static constexpr int kMaxRate = 240;        ///< 1/s

  /// One grasp.
  struct Hold {
    struct Point {
      double time = 0.0;                     ///< s since the record's start
      pbd::Vec3 wanted = pbd::Vec3::Zero();  ///< m, world: target of the held point
    };
    std::string body;                            ///< name in that room
    pbd::Vec3 attachment_l = pbd::Vec3::Zero();  ///< m, frame of the body
    std::vector<Point> way;                      ///< by time, starting with the grab; not empty
    double end = 0.0;                            ///< s, the release

    double start() const { return way.front().time; }
    /// Interpolated linearly.
    pbd::Vec3 wanted(double time) const;
  };
  std::string room;
  int rate = 60;            ///< 1/s, maximum of points
  double seconds = 0.0;     ///< s, length
  std::vector<Hold> holds;  ///< by time, without overlap
};

/// @param file  name in errors
/// @throws std::invalid_argument naming file, line, field, rule and value
HandRecord hand_record_from_text(std::string_view text, std::string_view file);
/// @throws std::runtime_error if it cannot be read @throws std::invalid_argument as above
HandRecord read_hand_record(const std::string& path);

}  // namespace tandem::demos
