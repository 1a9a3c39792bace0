/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * A frame's calls in C, for what they cost by themselves.
 */
#include "tandem/c/tandem.h"

__attribute__((visibility("default"))) void loop_steps(tandem_world* world,
                                                       const tandem_body* bodies, size_t count,
                                                       tandem_state* states, int32_t times) {
  for (int32_t i = 0; i < times; ++i) {
    tandem_step_report report;
    tandem_error error;
    tandem_world_step(world, 1.0 / 60.0, &report, &error);
    tandem_body_states(world, bodies, count, states, &error);
  }
}
