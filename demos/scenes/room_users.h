// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/person.h"

namespace tandem::demos {

void room_script(Person& person);

}  // namespace tandem::demos
