// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stands around the blocks of docs/scene_files.md.
#include <cstdio>
#include <string>

void read() {
  // page: Scenes from files
}
