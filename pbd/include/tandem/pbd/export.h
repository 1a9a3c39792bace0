// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

/// Marks symbols that the modules export: shared libraries (BUILD_SHARED_LIBS) hide all others.
/// Types without symbols are marked too, because template instances, exceptions and casts must be
/// the same in all libraries of a program.
/// Tandem's build defines TANDEM_DLL while it compiles a DLL. Users of DLLs need no mark, because
/// mingw's linker imports what is missing, data included.
#if defined(TANDEM_DLL)
#define TANDEM_API [[gnu::dllexport]]
#elif defined(__GNUC__)
#define TANDEM_API [[gnu::visibility("default")]]
#else
#define TANDEM_API
#endif
