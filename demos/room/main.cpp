// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users at two peers hand over, carry, stack and throw things in a room.

#include "program/demo_main.h"
#include "scenes/room.h"

int main(int argc, char** argv) {
  return tandem::demos::demo_main<tandem::demos::RoomScenario>(argc, argv);
}
