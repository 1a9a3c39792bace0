// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <mujoco/mujoco.h>

#include <string>

#include "grouped_warnings.h"
#include "tandem/scene_files.h"

namespace tandem::mjcf {

inline Vec3 vec(const mjtNum* v) { return {v[0], v[1], v[2]}; }
inline Pose pose_of(const mjtNum* position, const mjtNum* q) {
  return {vec(position), Quat(q[0], q[1], q[2], q[3]).normalized()};
}
inline Pose inverse(const Pose& pose) {
  const Quat back = pose.orientation.conjugate();
  return {-(back * pose.position), back};
}
inline Pose operator*(const Pose& a, const Pose& b) {
  return {a.to_world(b.position), (a.orientation * b.orientation).normalized()};
}

/// A compiled model, and its warnings.
struct Model {
  const mjModel& m;
  scene_files::GroupedWarnings warnings;

  /// May be empty.
  std::string name(mjtObj kind, int id) const {
    const char* text = mj_id2name(&m, kind, id);
    return text == nullptr ? std::string() : text;
  }
  /// Its index if it has no name.
  std::string title(mjtObj kind, int id) const {
    const std::string text = name(kind, id);
    return text.empty() ? std::to_string(id) : text;
  }
  std::string where(mjtObj kind, int id) const {
    return std::string(mju_type2Str(kind)) + ' ' + title(kind, id);
  }
  void warn(mjtObj kind, int id, const std::string& text) {
    warnings.add(mju_type2Str(kind), title(kind, id), text);
  }
  auto guard(mjtObj kind, int id, auto&& call) const {
    try {
      return call();
    } catch (const std::invalid_argument& error) {
      throw SceneFileError(where(kind, id) + ": " + error.what());
    }
  }
  /// Whether <flag> disables something, by itself or with all of MuJoCo's constraints.
  bool off(int flag) const {
    constexpr int kConstraints =
        mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_EQUALITY | mjDSBL_FRICTIONLOSS;
    const int flags = m.opt.disableflags;
    return (flags & flag) != 0 || ((flag & kConstraints) != 0 && (flags & mjDSBL_CONSTRAINT) != 0);
  }
};

}  // namespace tandem::mjcf
