// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/material.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "material_io.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

double combine(Combine rule, double a, double b) {
  switch (rule) {
    case Combine::Default:  // resolved by the callers
    case Combine::GeometricMean:
      return std::sqrt(a * b);
    case Combine::Average:
      return 0.5 * (a + b);
    case Combine::Minimum:
      return std::min(a, b);
    case Combine::Multiply:
      return a * b;
    case Combine::Maximum:
      return std::max(a, b);
  }
  return 0.0;
}

Combine resolve(Combine a, Combine b, Combine standard) {
  const Combine rule = std::max(a, b);
  return rule == Combine::Default ? standard : rule;
}

bool is_rule(Combine rule) { return rule <= Combine::Maximum; }

}  // namespace

bool Material::validate(std::string* error) const {
  const auto fail = [&](const char* field, double value, const char* rule) {
    if (error != nullptr) {
      *error = pbd::detail::must_be(std::string("Material.") + field, rule, value);
    }
    return false;
  };
  if (!(friction >= 0.0) || !std::isfinite(friction)) {
    return fail("friction", friction, "finite and >= 0");
  }
  if (!(restitution >= 0.0 && restitution <= 1.0)) {
    return fail("restitution", restitution, "from 0 to 1");
  }
  if (!is_rule(friction_rule)) {
    return fail("friction_rule", static_cast<double>(friction_rule), "one of Combine");
  }
  if (!is_rule(restitution_rule)) {
    return fail("restitution_rule", static_cast<double>(restitution_rule), "one of Combine");
  }
  return true;
}

double combined_friction(const Material& a, const Material& b) {
  return combine(resolve(a.friction_rule, b.friction_rule, Combine::GeometricMean), a.friction,
                 b.friction);
}

double combined_restitution(const Material& a, const Material& b) {
  return combine(resolve(a.restitution_rule, b.restitution_rule, Combine::Maximum), a.restitution,
                 b.restitution);
}

void save_surface(pbd::ByteWriter& out, const Material& material, const Filter& filter) {
  out.f64(material.friction);
  out.f64(material.restitution);
  out.u8(static_cast<std::uint8_t>(material.friction_rule));
  out.u8(static_cast<std::uint8_t>(material.restitution_rule));
  out.u32(filter.category);
  out.u32(filter.mask);
  out.u32(static_cast<std::uint32_t>(filter.group));
}

bool load_surface(pbd::ByteReader& in, Material& material, Filter& filter) {
  material.friction = in.f64();
  material.restitution = in.f64();
  material.friction_rule = static_cast<Combine>(in.u8());
  material.restitution_rule = static_cast<Combine>(in.u8());
  filter.category = in.u32();
  filter.mask = in.u32();
  filter.group = static_cast<std::int32_t>(in.u32());
  return !in.failed() && material.validate();
}

}  // namespace tandem::collision
