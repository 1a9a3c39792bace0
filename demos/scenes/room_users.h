// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/person.h"

namespace tandem::demos {

/// Gives user A (0) or B (1) of the room its script.
void room_script(Person& person);

}  // namespace tandem::demos
