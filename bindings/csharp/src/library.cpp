// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The contents of this library come from the others. The structs in Runtime follow one version of
// the header.
#include "tandem/c/tandem.h"

static_assert(TANDEM_C_VERSION == 2, "Runtime/Native.cs and the structs there must follow");
