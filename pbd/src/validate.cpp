// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/validate.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "tandem/pbd/world.h"

namespace tandem::pbd::detail {

std::string value_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

std::string must_be(std::string_view field, std::string_view rule, std::string_view value) {
  std::string text(field);
  text.append(" must be ").append(rule);
  if (!value.empty()) text.append(", is ").append(value);
  return text;
}

std::string must_be(std::string_view field, std::string_view rule, double value) {
  return must_be(field, rule, value_text(value));
}

void refuse(std::string_view field, std::string_view rule, std::string_view value) {
  throw std::invalid_argument(must_be(field, rule, value));
}

void refuse(std::string_view field, std::string_view rule, double value) {
  refuse(field, rule, value_text(value));
}

void require(bool ok, std::string_view kind, std::string_view field, double value,
             std::string_view rule) {
  if (!ok) refuse(std::string(kind).append(": ").append(field), rule, value);
}

void require_in(double low, double high, std::string_view kind, std::string_view field,
                double value, std::string_view unit) {
  if (value >= low && value <= high) return;  // before any text is made
  std::string rule = "from " + value_text(low) + " to " + value_text(high);
  if (!unit.empty()) rule.append(" ").append(unit);
  require(false, kind, field, value, rule);
}

void require_finite(const Vec3& value, std::string_view kind, std::string_view field) {
  for (int i = 0; i < 3; ++i) require(std::isfinite(value[i]), kind, field, value[i], "finite");
}

void require_unit(const Quat& value, std::string_view kind, std::string_view field) {
  const double norm = value.norm();
  // Also refuses NaN.
  require(std::abs(norm - 1.0) < 1e-3, kind, field, norm,
          "a quaternion of unit norm (within 1e-3)");
}

void require_body(const World& world, BodyId id, std::string_view kind, std::string_view field) {
  if (world.contains(id)) return;
  refuse(
      std::string(kind).append(": ").append(field), "a body of this world",
      "body " + std::to_string(id.index) + " (generation " + std::to_string(id.generation) + ")");
}

bool in_range(double value, double low, double high, std::string_view field, std::string* error) {
  if (value >= low && value <= high) return true;
  if (error != nullptr) {
    *error = must_be(field, "from " + value_text(low) + " to " + value_text(high), value);
  }
  return false;
}

}  // namespace tandem::pbd::detail
