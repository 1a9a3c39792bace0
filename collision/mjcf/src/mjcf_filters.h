// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "mjcf_model.h"
#include "tandem/collision/material.h"

namespace tandem::mjcf {

/// Which geoms meet: in MuJoCo two geoms meet if the contype of one overlaps the conaffinity of the
/// other. Each pair of values that occurs becomes a category.
class Filters {
 public:
  explicit Filters(Model& model);
  /// The filter of a geom; category and mask only.
  collision::Filter operator[](int geom) const;

 private:
  struct Kind {
    std::uint32_t type, affinity;
    std::uint32_t mask = 0;
    bool meets(const Kind& other) const {
      return (type & other.affinity) != 0 || (other.type & affinity) != 0;
    }
  };
  Kind kind(int geom) const {
    return {static_cast<std::uint32_t>(model_.m.geom_contype[geom]),
            static_cast<std::uint32_t>(model_.m.geom_conaffinity[geom])};
  }

  const Model& model_;
  std::vector<Kind> kinds_;  ///< one per category
};

}  // namespace tandem::mjcf
