/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TESTS_C_SESSION_MEMBERS_H
#define TESTS_C_SESSION_MEMBERS_H

#include "support.h"

/* A world without gravity, with one body. */
typedef struct room {
  tandem_world* world;
  tandem_body body;
} room;

static inline room make_room(double x) {
  room r;
  r.world = make_world(0);
  CHECK(tandem_world_set_gravity(r.world, (tandem_vec3){0, 0, 0}, NULL) == TANDEM_OK);
  r.body = add_body(r.world, TANDEM_DYNAMIC, x, 0.0);
  return r;
}

static inline double place_of(const tandem_world* world, tandem_body body) {
  tandem_state state = {{{0, 0, 0}, {0, 0, 0, 1}}, {{0, 0, 0}, {0, 0, 0}}};
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  return state.pose.position.x;
}

static inline double place(const room* r) { return place_of(r->world, r->body); }

/* Tests in refusals.c. */
void wrong_sessions_are_refused(void);
/* Tests in sockets.c. */
void sessions_over_sockets(void);

#endif
