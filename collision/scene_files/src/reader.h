// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "fields.h"
#include "place.h"

namespace tandem::scene_files {

template <class T>
void read(const Place& at, T& value);

/// Reads the fields that an object has, and warns of those that were never requested.
class Reader {
 public:
  explicit Reader(const Place& at) : at_(at) {
    if (!at.value().is_object()) at.refuse("an object");
  }

  template <class T>
  void operator()(const char* key, T& value) {
    if (has(key)) read(at_.at(key), value);
  }
  /// Whether the field exists; counts as a request.
  bool has(const char* key) {
    asked_.emplace_back(key);
    return at_.has(key);
  }
  const Place& at() const { return at_; }
  /// Call after all requests.
  void finish() const {
    for (const auto& item : at_.value().items()) {
      if (std::find(asked_.begin(), asked_.end(), item.key()) != asked_.end()) continue;
      at_.at(item.key().c_str()).warn("not known, and passed over");
    }
  }

 private:
  const Place& at_;
  std::vector<std::string_view> asked_;
};

template <std::size_t N>
Eigen::Matrix<double, static_cast<int>(N), 1> read_numbers(const Place& at) {
  if (!at.value().is_array() || at.size() != N) {
    at.refuse("an array of " + std::to_string(N) + " numbers");
  }
  Eigen::Matrix<double, static_cast<int>(N), 1> numbers;
  for (std::size_t i = 0; i < N; ++i) {
    numbers[static_cast<Eigen::Index>(i)] = at.at(i).number();
  }
  return numbers;
}

inline void read_value(const Place& at, double& value) { value = at.number(); }
inline void read_value(const Place& at, bool& value) {
  if (!at.value().is_boolean()) at.refuse("true or false");
  value = at.value().get<bool>();
}
inline void read_value(const Place& at, std::string& value) { value = at.text(); }
inline void read_value(const Place& at, std::int32_t& value) {
  using Limits = std::numeric_limits<std::int32_t>;
  value = static_cast<std::int32_t>(at.integer(Limits::min(), Limits::max()));
}
inline void read_value(const Place& at, std::uint32_t& value) {
  value = static_cast<std::uint32_t>(at.integer(0, std::numeric_limits<std::uint32_t>::max()));
}
inline void read_value(const Place& at, std::uint64_t& value) {
  if (!at.value().is_number_unsigned()) at.refuse("a whole number from 0 to 2^64 - 1");
  value = at.value().get<std::uint64_t>();
}
inline void read_value(const Place& at, Vec3& value) { value = read_numbers<3>(at); }
/// x, y, z, w.
inline void read_value(const Place& at, Quat& value) { value.coeffs() = read_numbers<4>(at); }
/// xx, yy, zz, xy, xz, yz.
inline void read_value(const Place& at, pbd::Mat3& value) {
  const auto m = read_numbers<6>(at);
  value << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
}
void read_value(const Place& at, collision::Shape& shape);
template <class T>
void read_value(const Place& at, std::optional<T>& value) {
  read_value(at, value.emplace());
}
template <class T, std::size_t N>
void read_value(const Place& at, std::array<T, N>& values) {
  if (at.size() != N) at.refuse("an array of " + std::to_string(N) + " values");
  for (std::size_t i = 0; i < N; ++i) read(at.at(i), values[i]);
}
template <class Enum>
std::enable_if_t<std::is_enum_v<Enum>> read_value(const Place& at, Enum& value) {
  const auto& names = EnumNames<Enum>::kAll;
  const auto found = std::find(names.begin(), names.end(), at.text());
  std::string rule;
  for (const std::string_view name : names) rule.append(rule.empty() ? "" : ", ").append(name);
  if (found == names.end()) at.refuse("one of " + rule);
  value = static_cast<Enum>(found - names.begin());
}

/// Objects by their fields, everything else by read_value().
template <class T>
void read(const Place& at, T& value) {
  if constexpr (requires(Reader & io) { fields(io, value); }) {
    Reader io(at);
    fields(io, value);
    if constexpr (std::is_same_v<T, pbd::JointAxis>) {
      if (!io.has("freedom") && (at.has("lower") || at.has("upper"))) {
        value.freedom = pbd::Freedom::Limited;
        if (!at.has("lower")) value.lower = -pbd::kUnlimited;
        if (!at.has("upper")) value.upper = pbd::kUnlimited;
      }
    }
    io.finish();
  } else {
    read_value(at, value);
  }
}

}  // namespace tandem::scene_files
