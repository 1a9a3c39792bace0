// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <type_traits>

#include "tandem/pbd/body.h"
#include "tandem/pbd/bytes.h"

/// Fields of snapshots, listed once for writing and reading: a function that lists fields calls
/// io(field, ...) with one of these two as io.
namespace tandem::pbd {

class FieldWriter {
 public:
  explicit FieldWriter(ByteWriter& out) : out_(out) {}
  void operator()(const auto&... values) { (put(values), ...); }

 private:
  template <class T>
  requires std::is_enum_v<T>
  void put(T value) { out_.u8(static_cast<std::uint8_t>(value)); }
  void put(bool value) { out_.u8(value ? 1 : 0); }
  void put(std::uint8_t value) { out_.u8(value); }
  void put(std::uint32_t value) { out_.u32(value); }
  void put(std::uint64_t value) { out_.u64(value); }
  void put(double value) { out_.f64(value); }
  void put(const Vec3& value) { out_.vec3(value); }
  void put(const Quat& value) { out_.quat(value); }
  void put(const Mat3& value) {  // row by row
    for (int k = 0; k < 9; ++k) out_.f64(value(k / 3, k % 3));
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& value : values) put(value);
  }
  void put(const BodyId& id) { (*this)(id.index, id.generation); }
  void put(const Pose& pose) { (*this)(pose.position, pose.orientation); }
  void put(const Twist& twist) { (*this)(twist.linear, twist.angular); }

  ByteWriter& out_;
};

class FieldReader {
 public:
  explicit FieldReader(ByteReader& in) : in_(in) {}
  void operator()(auto&... values) { (get(values), ...); }

 private:
  template <class T>
  requires std::is_enum_v<T>
  void get(T& value) { value = static_cast<T>(in_.u8()); }
  void get(bool& value) { value = in_.u8() != 0; }
  void get(std::uint8_t& value) { value = in_.u8(); }
  void get(std::uint32_t& value) { value = in_.u32(); }
  void get(std::uint64_t& value) { value = in_.u64(); }
  void get(double& value) { value = in_.f64(); }
  void get(Vec3& value) { value = in_.vec3(); }
  void get(Quat& value) { value = in_.quat(); }
  void get(Mat3& value) {
    for (int k = 0; k < 9; ++k) value(k / 3, k % 3) = in_.f64();
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& values) {
    for (T& value : values) get(value);
  }
  void get(BodyId& id) { (*this)(id.index, id.generation); }
  void get(Pose& pose) { (*this)(pose.position, pose.orientation); }
  void get(Twist& twist) { (*this)(twist.linear, twist.angular); }

  ByteReader& in_;
};

}  // namespace tandem::pbd
