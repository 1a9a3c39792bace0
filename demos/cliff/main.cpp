// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// A thousand balls are released over a cliff of triangles.

#include "program/demo_main.h"
#include "scenes/cliff.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::CliffScenario>(argc, argv);
}
