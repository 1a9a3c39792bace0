// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::mpi {

using Bytes = std::vector<std::byte>;

/// Writes numbers as in memory: ranks of one cluster run one program on one kind of machine.
class MessageWriter {
 public:
  explicit MessageWriter(Bytes& out) : out_(out) {}
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void vec3(const pbd::Vec3& v) { doubles({v.data(), 3}); }
  void quat(const pbd::Quat& q) { doubles({q.coeffs().data(), 4}); }
  /// Opaque bytes.
  void record(std::span<const std::byte> bytes) {
    put(static_cast<std::uint64_t>(bytes.size()));
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  /// Reserves room for `count` numbers, to be written by DoubleWriter.
  std::byte* room(std::size_t count) {
    const std::size_t at = out_.size();
    out_.resize(at + count * sizeof(double));
    return out_.data() + at;
  }
  void doubles(std::span<const double> values) {
    const std::size_t at = out_.size();
    out_.resize(at + values.size_bytes());
    std::memcpy(out_.data() + at, values.data(), values.size_bytes());
  }

 private:
  Bytes& out_;
};

/// Writes successive numbers into reserved room.
class DoubleWriter {
 public:
  explicit DoubleWriter(std::byte* at) : at_(at) {}
  void vec3(const pbd::Vec3& v) { copy(v.data(), 3); }
  void quat(const pbd::Quat& q) { copy(q.coeffs().data(), 4); }

 private:
  void copy(const double* from, std::size_t count) {
    std::memcpy(at_, from, count * sizeof(double));
    at_ += count * sizeof(double);
  }
  std::byte* at_;
};

/// Reads what MessageWriter wrote. Past the end all is 0, and failed() is true.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> in) : in_(in) {}
  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    take(&value, sizeof(T));
    return value;
  }
  pbd::Vec3 vec3() {
    pbd::Vec3 v = pbd::Vec3::Zero();
    take(v.data(), 3 * sizeof(double));
    return v;
  }
  pbd::Quat quat() {
    pbd::Quat q = pbd::Quat::Identity();
    take(q.coeffs().data(), 4 * sizeof(double));
    return q;
  }
  std::span<const std::byte> record() {
    const auto size = get<std::uint64_t>();
    if (remaining() < size) fail();
    const auto bytes = failed_ ? std::span<const std::byte>{} : in_.subspan(at_, size);
    at_ += bytes.size();
    return bytes;
  }
  std::size_t remaining() const { return in_.size() - at_; }
  /// The contents are impossible.
  void fail() {
    failed_ = true;
    at_ = in_.size();
  }
  bool failed() const { return failed_; }

 private:
  void take(void* to, std::size_t size) {
    if (remaining() < size) return fail();
    std::memcpy(to, in_.data() + at_, size);
    at_ += size;
  }
  std::span<const std::byte> in_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

}  // namespace tandem::mpi
