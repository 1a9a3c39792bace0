// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "tandem/scene.h"

namespace tandem::everyday {

inline const Vec3 kCardHalf(0.005, 0.1, 0.2);  // m

/// Five storeys of leaning cards, 1 cm thick, with others across them; all start with 3 mm of
/// overlap. The ground is at z = 0.
std::vector<Pose> house_of_cards();

}  // namespace tandem::everyday
