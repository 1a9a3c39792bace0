// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

/// Marks what the modules show of themselves: in shared libraries (BUILD_SHARED_LIBS) all else is
/// hidden. On types as well that have nothing to link, since what is made from them by templates,
/// and how exceptions and casts know them, must be one in all libraries of a program.
#if defined(__GNUC__)
#define TANDEM_API [[gnu::visibility("default")]]
#else
#define TANDEM_API
#endif
