// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_record.h"

namespace tandem::pbd {

/// Whether any motor moves the joint on: it has not arrived, no limit stops it, and it manages its
/// load.
bool motors_run(const JointRecord& record);

}  // namespace tandem::pbd
