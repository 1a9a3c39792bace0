// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem::pbd {

/// Appends numbers of any width to bytes, the lowest bit first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::byte>& out) : out_(out) {}

  /// The lowest `count` bits of a value. @pre count <= 56
  void put(std::uint64_t value, unsigned count) {
    buffer_ |= (value & ((std::uint64_t{1} << count) - 1)) << filled_;
    filled_ += count;
    for (; filled_ >= 8; filled_ -= 8, buffer_ >>= 8) {
      out_.push_back(static_cast<std::byte>(buffer_ & 0xff));
    }
  }
  void put_signed(std::int64_t value, unsigned count) {
    put(static_cast<std::uint64_t>(value), count);
  }
  /// Fill the last byte with zeros.
  void finish() {
    if (filled_ > 0) put(0, 8 - filled_);
  }

 private:
  std::vector<std::byte>& out_;
  std::uint64_t buffer_ = 0;
  unsigned filled_ = 0;
};

/// Reads what BitWriter wrote. Reading past the end returns zeros and sets failed() for good.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> in) : in_(in) {}

  /// @pre count <= 56
  std::uint64_t get(unsigned count) {
    for (; filled_ < count && at_ < in_.size(); filled_ += 8) {
      buffer_ |= std::uint64_t{std::to_integer<std::uint8_t>(in_[at_++])} << filled_;
    }
    if (filled_ < count) {
      failed_ = true;
      return 0;
    }
    const std::uint64_t value = buffer_ & ((std::uint64_t{1} << count) - 1);
    buffer_ >>= count;
    filled_ -= count;
    return value;
  }
  bool flag() { return get(1) != 0; }
  /// A two's complement number. @pre count >= 1
  std::int64_t get_signed(unsigned count) {
    const std::uint64_t value = get(count);
    const std::uint64_t sign = std::uint64_t{1} << (count - 1);
    return static_cast<std::int64_t>(value ^ sign) - static_cast<std::int64_t>(sign);
  }
  bool failed() const { return failed_; }
  /// Whether all bytes were read and the unread bits of the last one are zero.
  bool at_end() const { return at_ == in_.size() && filled_ < 8 && buffer_ == 0; }

 private:
  std::span<const std::byte> in_;
  std::size_t at_ = 0;
  std::uint64_t buffer_ = 0;
  unsigned filled_ = 0;
  bool failed_ = false;
};

}  // namespace tandem::pbd
