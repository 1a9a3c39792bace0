// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "tandem/scene.h"

namespace tandem::everyday {

inline const Vec3 kCardHalf(0.005, 0.1, 0.2);  // m

/// Five storeys of leaning cards with others across them, 1 cm thick; all overlap by 3 mm at the
/// start. The ground is at z = 0.
std::vector<Pose> house_of_cards();

}  // namespace tandem::everyday
