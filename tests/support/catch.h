// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

// The one place that names the test framework's header (Catch2 2.13).
#include <catch2/catch.hpp>
