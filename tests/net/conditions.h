// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

namespace conditions_test {

/// Effects of a network on its datagrams, each way.
struct Condition {
  const char* name;
  double lag = 0.0;        // s, one way
  double jitter = 0.0;     // s, uniform on top
  double loss = 0.0;       // chance
  double duplicate = 0.0;  // chance
  double reorder = 0.0;    // chance to be held back by 50 ms
  double kbit = 0.0;       // kbit/s, with a queue of half a second; 0 = no limit
};

inline constexpr std::array<Condition, 15> kConditions{{
    {.name = "nothing"},
    {.name = "lag 20 ms", .lag = 0.02},
    {.name = "lag 100 ms", .lag = 0.1},
    {.name = "lag 250 ms", .lag = 0.25},
    {.name = "jitter 20 ms", .lag = 0.02, .jitter = 0.02},
    {.name = "jitter 80 ms", .lag = 0.04, .jitter = 0.08},
    {.name = "loss 1 %", .lag = 0.02, .loss = 0.01},
    {.name = "loss 10 %", .lag = 0.02, .loss = 0.1},
    {.name = "loss 30 %", .lag = 0.02, .loss = 0.3},
    {.name = "one in five twice", .lag = 0.02, .duplicate = 0.2},
    {.name = "all twice", .lag = 0.02, .duplicate = 1.0},
    {.name = "one in ten held back", .lag = 0.02, .reorder = 0.1},
    {.name = "256 kbit/s", .lag = 0.02, .kbit = 256.0},
    {.name = "128 kbit/s", .lag = 0.05, .kbit = 128.0},
    {.name = "all at once",
     .lag = 0.06,
     .jitter = 0.03,
     .loss = 0.1,
     .duplicate = 0.1,
     .reorder = 0.1,
     .kbit = 512.0},
}};

}  // namespace conditions_test
