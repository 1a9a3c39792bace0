// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Two users with haptic devices carry a piano through a maze. --variant takes soft, mouse, tug, or
// several of them joined by -.

#include "program/demo_main.h"
#include "scenes/piano.h"

int main(int argc, char** argv) {
  using namespace tandem::demos;
  return demo_main(argc, argv, [](const std::string& variant) -> std::unique_ptr<Scenario> {
    PianoOptions options;
    if (!PianoOptions::parse(variant, options)) {
      refuse("--variant", variant, "soft, mouse, tug, or several of them with - between");
    }
    return std::make_unique<PianoScenario>(options);
  });
}
