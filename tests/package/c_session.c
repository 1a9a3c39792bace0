/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#include <stdio.h>

#include "tandem/c/tandem.h"

/* Alone in a session on loopback for a tenth of a second. */
int main(void) {
  tandem_world_def world_def;
  tandem_session_def def;
  tandem_tcp_def tcp;
  tandem_body_def body_def;
  tandem_body body;
  tandem_error error;
  tandem_world_def_init(&world_def);
  tandem_session_def_init(&def);
  tandem_tcp_def_init(&tcp);
  tandem_body_def_init(&body_def);
  tcp.self = 1;
  tcp.listen_port = 0;
  tcp.listen_address = "127.0.0.1";
  tandem_world* world = tandem_world_create(&world_def, &error);
  tandem_session* session = tandem_session_create_tcp(world, &tcp, &def, &error);
  if (session == NULL || tandem_body_add(world, &body_def, &body, &error) != TANDEM_OK ||
      tandem_session_share(session, "ball", body, 0, NULL, &error) != TANDEM_OK) {
    fprintf(stderr, "%s\n", error.text);
    return 1;
  }
  int steps = 0;
  while (steps < 6) {
    tandem_progress progress;
    if (tandem_session_advance(session, tandem_session_now(session), NULL, NULL, &progress,
                               &error) != TANDEM_OK) {
      return 1;
    }
    steps += progress.steps;
  }
  tandem_state state;
  tandem_body_state(world, body, &state, NULL);
  tandem_session_destroy(session);
  tandem_world_destroy(world);
  return state.pose.position.z < 0.0 ? 0 : 1;
}
