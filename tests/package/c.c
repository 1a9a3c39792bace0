/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#include <stdio.h>

#include "tandem/c/tandem.h"

int main(void) {
  tandem_world_def def;
  tandem_error error;
  tandem_world_def_init(&def);
  tandem_world* world = tandem_world_create(&def, &error);
  tandem_body_def body_def;
  tandem_body body;
  tandem_state state;
  tandem_body_def_init(&body_def);
  if (world == NULL || tandem_body_add(world, &body_def, &body, &error) != TANDEM_OK) {
    fprintf(stderr, "%s\n", error.text);
    return 1;
  }
  for (int i = 0; i < 60; ++i) tandem_world_step(world, 1.0 / 60.0, NULL, NULL);
  tandem_body_state(world, body, &state, NULL);
  tandem_world_destroy(world);
  return state.pose.position.z < -4.8 ? 0 : 1;
}
