// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/bytes.h"

#include <array>
#include <bit>
#include <cstring>

#include "tandem/pbd/bit_cast.h"

namespace tandem::pbd {
namespace {

constexpr bool kLittle = std::endian::native == std::endian::little;

}  // namespace

void ByteWriter::put(std::uint64_t value, int count) {
  std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(value >> (8 * i));
  out_.insert(out_.end(), bytes.begin(), bytes.begin() + count);
}

void ByteWriter::f32(float value) { u32(bit_cast<std::uint32_t>(value)); }
void ByteWriter::f64(double value) { u64(bit_cast<std::uint64_t>(value)); }

void ByteWriter::vec3(const Vec3& value) {
  for (int i = 0; i < 3; ++i) f64(value[i]);
}

void ByteWriter::quat(const Quat& value) {
  f64(value.w());
  f64(value.x());
  f64(value.y());
  f64(value.z());
}

void ByteWriter::bytes(std::span<const std::byte> value) {
  out_.insert(out_.end(), value.begin(), value.end());
}

std::uint64_t ByteReader::get(int count) {
  if (failed_ || remaining() < static_cast<std::size_t>(count)) {
    failed_ = true;
    return 0;
  }
  std::uint64_t value = 0;
  if (kLittle && remaining() >= sizeof(value)) {  // fast path, same result as below
    std::memcpy(&value, &in_[at_], sizeof(value));
    value &= ~std::uint64_t{0} >> (64 - 8 * count);
    at_ += static_cast<std::size_t>(count);
    return value;
  }
  for (int i = 0; i < count; ++i) {
    value |= static_cast<std::uint64_t>(in_[at_ + static_cast<std::size_t>(i)]) << (8 * i);
  }
  at_ += static_cast<std::size_t>(count);
  return value;
}

float ByteReader::f32() { return bit_cast<float>(u32()); }
double ByteReader::f64() { return bit_cast<double>(u64()); }

Vec3 ByteReader::vec3() {
  const double x = f64();
  const double y = f64();
  const double z = f64();
  return {x, y, z};
}

Quat ByteReader::quat() {
  const double w = f64();
  const double x = f64();
  const double y = f64();
  const double z = f64();
  return Quat(w, x, y, z);
}

std::span<const std::byte> ByteReader::bytes(std::size_t count) {
  if (failed_ || remaining() < count) {
    failed_ = true;
    return {};
  }
  const auto view = in_.subspan(at_, count);
  at_ += count;
  return view;
}

std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed) {
  std::uint64_t hash = seed;
  for (const std::byte b : bytes) {
    hash ^= static_cast<std::uint64_t>(b);
    hash *= 0x100000001b3ull;
  }
  return hash;
}

}  // namespace tandem::pbd
