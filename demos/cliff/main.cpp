// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// A thousand balls, held in the air, then let go over a cliff of triangles.

#include "program/demo_main.h"
#include "scenes/cliff.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::CliffScenario>(argc, argv);
}
