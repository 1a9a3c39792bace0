// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users at two peers throw stacked cubes over and carry them on their plate together.

#include "program/demo_main.h"
#include "scenes/cubes.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::CubesScenario>(argc, argv);
}
