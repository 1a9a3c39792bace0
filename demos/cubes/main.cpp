// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users at two peers knock over stacked cubes and carry them together on their plate.

#include "program/demo_main.h"
#include "scenes/cubes.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::CubesScenario>(argc, argv);
}
