// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#define CATCH_CONFIG_MAIN
#include "support/catch.h"
