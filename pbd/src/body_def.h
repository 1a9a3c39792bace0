// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string_view>

#include "tandem/pbd/body.h"

/// Checks of body definitions. All throw std::invalid_argument naming `kind`, the field, its value
/// and the rule.
namespace tandem::pbd {

/// Finite, with an orientation of unit norm.
void check_pose(const Pose& pose, std::string_view kind);
void check_twist(const Twist& twist, std::string_view kind);
void check_damping(double linear, double angular, std::string_view kind);
void check_def(const BodyDef& def);

/// @pre the definition has been checked
BodyProps make_props(const BodyDef& def);

}  // namespace tandem::pbd
