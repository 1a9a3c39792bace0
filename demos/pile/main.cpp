// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users roll a big cube through nine hundred small ones.

#include "program/demo_main.h"
#include "scenes/pile.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::PileScenario>(argc, argv);
}
