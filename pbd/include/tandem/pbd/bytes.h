// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::pbd {

/// Appends little-endian values to a growing buffer, whatever the machine's byte order.
class TANDEM_API ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::byte>& out) : out_(out) {}

  void u8(std::uint8_t value) { put(value, 1); }
  void u16(std::uint16_t value) { put(value, 2); }
  void u32(std::uint32_t value) { put(value, 4); }
  void u64(std::uint64_t value) { put(value, 8); }
  void i64(std::int64_t value) { put(static_cast<std::uint64_t>(value), 8); }
  void f32(float value);
  void f64(double value);
  void vec3(const Vec3& value);
  void quat(const Quat& value);  ///< w, x, y, z
  void bytes(std::span<const std::byte> value);

 private:
  void put(std::uint64_t value, int count);
  std::vector<std::byte>& out_;
};

/// Reads what ByteWriter wrote. Reading past the end returns zeros and sets failed() for good:
/// check it once, after the last read. Callers that find an invalid value call fail().
class TANDEM_API ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> in) : in_(in) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(get(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(get(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(get(4)); }
  std::uint64_t u64() { return get(8); }
  std::int64_t i64() { return static_cast<std::int64_t>(get(8)); }
  float f32();
  double f64();
  Vec3 vec3();
  Quat quat();
  /// A view of the next `count` bytes of the input; empty, with failed() set, if fewer remain.
  std::span<const std::byte> bytes(std::size_t count);

  std::size_t remaining() const { return in_.size() - at_; }
  bool failed() const { return failed_; }
  void fail() { failed_ = true; }

 private:
  std::uint64_t get(int count);
  std::span<const std::byte> in_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

/// 64-bit FNV-1a over bytes; `seed` chains calls.
TANDEM_API std::uint64_t hash_bytes(std::span<const std::byte> bytes,
                                    std::uint64_t seed = 0xcbf29ce484222325ull);

}  // namespace tandem::pbd
