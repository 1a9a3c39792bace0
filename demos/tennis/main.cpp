// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users at two peers play table tennis, each with only their own peer's view.

#include "program/demo_main.h"
#include "scenes/tennis.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::TennisScenario>(argc, argv);
}
