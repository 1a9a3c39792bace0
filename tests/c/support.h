/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TESTS_C_SUPPORT_H
#define TESTS_C_SUPPORT_H

#include <stdio.h>
#include <stdlib.h>

#include "tandem/c/tandem.h"

extern int failures;

#define CHECK(claim)                                              \
  do {                                                            \
    if (!(claim)) {                                               \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #claim); \
      ++failures;                                                 \
    }                                                             \
  } while (0)

static const double kStep = 1.0 / 60.0;

static inline tandem_world* make_world(int events) {
  tandem_world_def def;
  tandem_error error;
  tandem_world_def_init(&def);
  def.events = events;
  tandem_world* world = tandem_world_create(&def, &error);
  if (world == NULL) {
    fprintf(stderr, "no world: %s\n", error.text);
    exit(1);
  }
  return world;
}

static inline tandem_body add_body(tandem_world* world, tandem_body_type type, double x, double z) {
  tandem_body_def def;
  tandem_body body = TANDEM_NO_BODY;
  tandem_body_def_init(&def);
  def.type = type;
  def.pose.position.x = x;
  def.pose.position.z = z;
  CHECK(tandem_body_add(world, &def, &body, NULL) == TANDEM_OK);
  return body;
}

static inline tandem_collider add_shape(tandem_world* world, tandem_body body,
                                        tandem_shape_kind kind) {
  tandem_collider_def def;
  tandem_collider collider = {0, 0};
  tandem_collider_def_init(&def, kind);
  def.body = body;
  CHECK(tandem_collider_add(world, &def, &collider, NULL) == TANDEM_OK);
  return collider;
}

/* Tests in parts.c. */
void parts_move(void);
/* Tests in refusals.c. */
void what_is_wrong_is_refused(void);
/* Tests in queries.c. */
void queries_find(void);
/* Tests in sessions.c. */
void peers_share(void);

#endif
