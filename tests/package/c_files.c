/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#include <stdio.h>
#include <string.h>

#include "tandem/c/tandem.h"

/* A ball on the ground, by text. */
int main(void) {
  static const char text[] =
      "{\"bodies\": [{\"type\": \"static\", \"shape\": {\"type\": \"halfSpace\"}},"
      "{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius\": 0.1},"
      " \"position\": [0, 0, 0.3]}]}";
  tandem_world_def def;
  tandem_error error;
  tandem_scene_file* file = NULL;
  tandem_body ball;
  tandem_state state;
  tandem_world_def_init(&def);
  tandem_world* world =
      tandem_scene_parse(TANDEM_SCENE_JSON, text, strlen(text), NULL, &def, &file, &error);
  if (world == NULL || tandem_scene_file_find_body(file, "ball", &ball, &error) != TANDEM_OK) {
    fprintf(stderr, "%s\n", error.text);
    return 1;
  }
  for (int i = 0; i < 120; ++i) tandem_world_step(world, 1.0 / 60.0, NULL, NULL);
  tandem_body_state(world, ball, &state, NULL);
  tandem_scene_file_destroy(file);
  tandem_world_destroy(world);
  return state.pose.position.z > 0.099 && state.pose.position.z < 0.101 ? 0 : 1;
}
