// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "core.h"

namespace tandem::python {

/// A joint of a scene, which it keeps alive.
struct Joint {
  CorePtr core;
  pbd::JointId id;

  pbd::JointBlock& block() const { return core->scene().joints(); }
  const pbd::JointState& state() const { return block().at(id); }
};

}  // namespace tandem::python
