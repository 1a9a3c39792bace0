// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_filters.h"

#include <algorithm>

#include "tandem/pbd/validate.h"

namespace tandem::mjcf {
namespace {

constexpr std::size_t kCategories = 32;

}  // namespace

Filters::Filters(Model& model) : model_(model) {
  if (model.off(mjDSBL_CONTACT)) return;
  const auto same = [](const Kind& other) {
    return [&other](const Kind& one) {
      return one.type == other.type && one.affinity == other.affinity;
    };
  };
  // MuJoCo's default first: bit 0 is what colliders added by an application have.
  kinds_.push_back({.type = 1, .affinity = 1});
  for (int g = 0; g < model.m.ngeom; ++g) {
    const Kind one = kind(g);
    if (one.type == 0 && one.affinity == 0) continue;  // meets nothing
    if (std::any_of(kinds_.begin(), kinds_.end(), same(one))) continue;
    if (kinds_.size() == kCategories) {
      throw SceneFileError(
          pbd::detail::must_be(model.where(mjOBJ_GEOM, g) + ": contype and conaffinity",
                               "one of at most 32 pairs of values in a model"));
    }
    kinds_.push_back(one);
  }
  for (Kind& one : kinds_) {
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
      if (one.meets(kinds_[k])) one.mask |= 1u << k;
    }
  }
}

collision::Filter Filters::operator[](int geom) const {
  const Kind own = kind(geom);
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    if (kinds_[k].type == own.type && kinds_[k].affinity == own.affinity) {
      return {.category = 1u << k, .mask = kinds_[k].mask};
    }
  }
  return {.category = 0, .mask = 0};  // meets nothing, or contacts are off
}

}  // namespace tandem::mjcf
