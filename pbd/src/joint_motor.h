// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_record.h"

namespace tandem::pbd {

/// Whether any motor moves the joint: it has not arrived, is not at a limit, and can move its load.
bool motors_run(const JointRecord& record);

}  // namespace tandem::pbd
