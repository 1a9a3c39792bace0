/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Rays, casts, overlaps and nearest places: a ball of half a metre 3 m away, a box of 1 m behind
 * it.
 */
#include <math.h>

#include "support.h"
#include "tandem/c/tandem.h"

typedef struct scene {
  tandem_world* world;
  tandem_query* query;
  tandem_body ball, box;
  tandem_collider ball_shape, box_shape;
} scene;

static scene make_scene(void) {
  scene s;
  s.world = make_world(0);
  s.ball = add_body(s.world, TANDEM_STATIC, 3.0, 0.0);
  s.box = add_body(s.world, TANDEM_STATIC, 6.0, 0.0);
  s.ball_shape = add_shape(s.world, s.ball, TANDEM_SPHERE);
  s.box_shape = add_shape(s.world, s.box, TANDEM_BOX);
  s.query = tandem_query_create(s.world, NULL);
  CHECK(s.query != NULL);
  return s;
}

static void destroy_scene(const scene* s) {
  tandem_query_destroy(s->query);
  tandem_world_destroy(s->world);
}

static int same(tandem_collider a, tandem_collider b) {
  return a.index == b.index && a.generation == b.generation;
}

static int32_t accept_other(void* user, tandem_collider collider) {
  return same(*(const tandem_collider*)user, collider) == 0;
}

static void rays_hit_what_is_in_their_way(void) {
  const scene s = make_scene();
  const tandem_vec3 origin = {0, 0, 0}, along = {2, 0, 0}, away = {-1, 0, 0};
  tandem_query_hit hits[4];
  size_t count = 9;
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, NULL, hits, 4, &count, NULL) == TANDEM_OK);
  CHECK(count == 2 && same(hits[0].collider, s.ball_shape) && same(hits[1].collider, s.box_shape));
  CHECK(fabs(hits[0].distance - 2.5) < 1e-9 && fabs(hits[0].fraction - 0.025) < 1e-9);
  CHECK(fabs(hits[0].point.x - 2.5) < 1e-9 && fabs(hits[0].normal.x + 1.0) < 1e-9);
  CHECK(fabs(hits[1].distance - 5.5) < 1e-9 && hits[1].triangle == 0xffffffffu);
  CHECK(hits[1].body.index == s.box.index);
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, NULL, hits, 1, &count, NULL) == TANDEM_OK);
  CHECK(count == 1 && same(hits[0].collider, s.ball_shape));
  CHECK(tandem_query_ray(s.query, origin, along, 2.0, NULL, NULL, 0, &count, NULL) == TANDEM_OK);
  CHECK(count == 0);
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, NULL, NULL, 0, &count, NULL) == TANDEM_OK);
  CHECK(count == 1);
  CHECK(tandem_query_ray(s.query, origin, away, 100.0, NULL, hits, 4, &count, NULL) == TANDEM_OK);
  CHECK(count == 0);

  tandem_query_filter filter;
  tandem_query_filter_init(&filter);
  filter.ignore = s.ball;
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, &filter, hits, 1, &count, NULL) ==
        TANDEM_OK);
  CHECK(count == 1 && same(hits[0].collider, s.box_shape));
  tandem_query_filter_init(&filter);
  tandem_collider refused = s.box_shape;
  filter.accept = accept_other;
  filter.user = &refused;
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, &filter, hits, 4, &count, NULL) ==
        TANDEM_OK);
  CHECK(count == 1 && same(hits[0].collider, s.ball_shape));
  filter.accept = NULL;
  filter.mask = 0;
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, &filter, hits, 4, &count, NULL) ==
        TANDEM_OK);
  CHECK(count == 0);
  destroy_scene(&s);
}

static void shapes_meet_what_they_must(void) {
  const scene s = make_scene();
  const tandem_pose here = {{0, 0, 0}, {0, 0, 0, 1}};
  tandem_pose inside = here;
  inside.position.x = 3.2;
  tandem_shape ball;
  tandem_query_hit hits[4];
  tandem_collider found[4];
  size_t count = 9;
  tandem_shape_init(&ball, TANDEM_SPHERE); /* of half a metre */
  CHECK(tandem_query_cast(s.query, &ball, &here, (tandem_vec3){10, 0, 0}, NULL, hits, 4, &count,
                          NULL) == TANDEM_OK);
  CHECK(count == 2 && fabs(hits[0].fraction - 0.2) < 1e-6 && fabs(hits[1].fraction - 0.5) < 1e-6);
  CHECK(tandem_query_cast(s.query, &ball, &here, (tandem_vec3){0, 10, 0}, NULL, hits, 1, &count,
                          NULL) == TANDEM_OK);
  CHECK(count == 0);
  CHECK(tandem_query_closest(s.query, &ball, &here, 10.0, NULL, hits, 4, &count, NULL) ==
        TANDEM_OK);
  CHECK(count == 2 && fabs(hits[0].distance - 2.0) < 1e-6 && fabs(hits[1].distance - 5.0) < 1e-6);
  CHECK(tandem_query_closest(s.query, NULL, &here, 10.0, NULL, hits, 1, &count, NULL) == TANDEM_OK);
  CHECK(count == 1 && fabs(hits[0].distance - 2.5) < 1e-9 && fabs(hits[0].point.x - 2.5) < 1e-9);
  CHECK(tandem_query_closest(s.query, NULL, &here, 10.0, NULL, hits, 4, &count, NULL) == TANDEM_OK);
  CHECK(count == 2 && fabs(hits[1].distance - 5.5) < 1e-6);
  CHECK(tandem_query_closest(s.query, NULL, &here, 1.0, NULL, hits, 4, &count, NULL) == TANDEM_OK);
  CHECK(count == 0);
  CHECK(tandem_query_overlap(s.query, &ball, &inside, NULL, found, 4, &count, NULL) == TANDEM_OK);
  CHECK(count == 1 && same(found[0], s.ball_shape));
  CHECK(tandem_query_overlap(s.query, &ball, &here, NULL, NULL, 0, &count, NULL) == TANDEM_OK);
  CHECK(count == 0);
  destroy_scene(&s);
}

/* A query sees the world of its last update. */
static void queries_see_their_last_update(void) {
  const scene s = make_scene();
  const tandem_vec3 origin = {0, 0, 0}, along = {1, 0, 0};
  const tandem_pose nearer = {{2, 0, 0}, {0, 0, 0, 1}};
  tandem_query_hit hit;
  size_t count = 0;
  CHECK(tandem_body_set_pose(s.world, s.ball, &nearer, NULL) == TANDEM_OK);
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, NULL, &hit, 1, &count, NULL) == TANDEM_OK);
  CHECK(count == 1 && fabs(hit.distance - 2.5) < 1e-9);
  CHECK(tandem_query_update(s.query, NULL) == TANDEM_OK);
  CHECK(tandem_query_ray(s.query, origin, along, 100.0, NULL, &hit, 1, &count, NULL) == TANDEM_OK);
  CHECK(count == 1 && fabs(hit.distance - 1.5) < 1e-9);
  destroy_scene(&s);
}

static void what_cannot_be_asked_is_refused(void) {
  const scene s = make_scene();
  const tandem_vec3 origin = {0, 0, 0}, nowhere = {0, 0, 0}, along = {1, 0, 0};
  const tandem_pose here = {{0, 0, 0}, {0, 0, 0, 1}};
  tandem_shape plane;
  tandem_query_hit hit;
  size_t count = 0;
  tandem_shape_init(&plane, TANDEM_HALF_SPACE);
  CHECK(tandem_query_create(NULL, NULL) == NULL);
  CHECK(tandem_query_update(NULL, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_ray(s.query, origin, nowhere, 1.0, NULL, &hit, 1, &count, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_ray(s.query, origin, along, -1.0, NULL, &hit, 1, &count, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_ray(s.query, origin, along, 9.0, NULL, NULL, 1, &count, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_ray(s.query, origin, along, 9.0, NULL, &hit, 1, NULL, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_overlap(s.query, &plane, &here, NULL, NULL, 0, &count, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_query_cast(s.query, NULL, &here, along, NULL, &hit, 1, &count, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  destroy_scene(&s);
}

void queries_find(void) {
  rays_hit_what_is_in_their_way();
  shapes_meet_what_they_must();
  queries_see_their_last_update();
  what_cannot_be_asked_is_refused();
}
