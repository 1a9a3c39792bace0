/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * The C interface from C. Each case claims something that its physics says by itself.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"
#include "tandem/c/tandem.h"

int failures = 0;

static double height(const tandem_world* world, tandem_body body) {
  tandem_state state;
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  return state.pose.position.z;
}

/* The semi-implicit step of n substeps falls g t^2 / 2 (1 + 1 / n) in n of them. */
static void falls_as_it_must(void) {
  tandem_world* world = make_world(0);
  const tandem_body body = add_body(world, TANDEM_DYNAMIC, 0.0, 10.0);
  for (int i = 0; i < 60; ++i) CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
  CHECK(fabs(height(world, body) - (10.0 - 0.5 * 9.81 * (1.0 + 1.0 / 240.0))) < 1e-9);
  tandem_world_destroy(world);
}

/* A body of 1 kg and 0.4 kg m^2: what pushes it is its change of motion. */
static void pushes_change_motion(void) {
  tandem_world* world = make_world(0);
  CHECK(tandem_world_set_gravity(world, (tandem_vec3){0, 0, 0}, NULL) == TANDEM_OK);
  const tandem_body body = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  const tandem_vec3 aside = {0.0, 1.0, 0.0};
  CHECK(tandem_body_apply_force(world, body, (tandem_vec3){3.0, 0, 0}, NULL, NULL) == TANDEM_OK);
  CHECK(tandem_body_apply_torque(world, body, (tandem_vec3){0, 0, 6.0}, NULL) == TANDEM_OK);
  for (int i = 0; i < 2; ++i) tandem_world_step(world, kStep, NULL, NULL); /* in the first alone */
  tandem_state state;
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  CHECK(fabs(state.twist.linear.x - 3.0 * kStep) < 1e-12);
  CHECK(fabs(state.twist.angular.z - 6.0 * kStep / 0.4) < 1e-9);

  const tandem_twist still = {{0, 0, 0}, {0, 0, 0}};
  CHECK(tandem_body_set_twist(world, body, &still, NULL) == TANDEM_OK);
  CHECK(tandem_body_set_pose(world, body, &(tandem_pose){{0, 0, 0}, {0, 0, 0, 1}}, NULL) ==
        TANDEM_OK);
  CHECK(tandem_body_apply_impulse(world, body, (tandem_vec3){2.0, 0, 0}, &aside, NULL) ==
        TANDEM_OK);
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  CHECK(fabs(state.twist.linear.x - 2.0) < 1e-12);
  CHECK(fabs(state.twist.angular.z + 2.0 / 0.4) < 1e-12); /* arm x impulse = y x x = -z */
  CHECK(tandem_body_apply_impulse(world, body, (tandem_vec3){NAN, 0, 0}, NULL, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  tandem_world_destroy(world);
}

/* A kinematic body is where it was sent after one step; the states of many are those of each. */
static void many_are_where_each_is(void) {
  tandem_world* world = make_world(0);
  const tandem_body bodies[2] = {add_body(world, TANDEM_KINEMATIC, 1.0, 0.0),
                                 add_body(world, TANDEM_DYNAMIC, 2.0, 5.0)};
  const tandem_pose there = {{1.0, 0.5, 0.0}, {0, 0, 0, 1}};
  CHECK(tandem_body_move_to(world, bodies[0], &there, NULL) == TANDEM_OK);
  CHECK(tandem_body_move_to(world, bodies[1], &there, NULL) == TANDEM_INVALID_ARGUMENT);
  tandem_world_step(world, kStep, NULL, NULL);
  tandem_state states[2];
  CHECK(tandem_body_states(world, bodies, 2, states, NULL) == TANDEM_OK);
  CHECK(fabs(states[0].pose.position.y - 0.5) < 1e-12);
  for (int i = 0; i < 2; ++i) {
    tandem_state alone;
    CHECK(tandem_body_state(world, bodies[i], &alone, NULL) == TANDEM_OK);
    CHECK(memcmp(&alone, &states[i], sizeof alone) == 0);
  }
  const tandem_body gone[2] = {bodies[0], TANDEM_NO_BODY};
  CHECK(tandem_body_states(world, gone, 2, states, NULL) == TANDEM_INVALID_ARGUMENT);
  tandem_world_destroy(world);
}

static void comes_to_rest_on_the_ground(void) {
  tandem_world* world = make_world(1);
  const tandem_body ground = add_body(world, TANDEM_STATIC, 0.0, 0.0);
  const tandem_body ball = add_body(world, TANDEM_DYNAMIC, 0.0, 1.0);
  add_shape(world, ground, TANDEM_HALF_SPACE);
  const tandem_collider collider = add_shape(world, ball, TANDEM_SPHERE);
  size_t begun = 0, hits = 0;
  for (int i = 0; i < 240; ++i) {
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
    tandem_hit hit;
    begun += tandem_world_contacts(world, TANDEM_BEGUN, NULL, 0);
    if (tandem_world_hits(world, &hit, 1) == 1) {
      ++hits;
      /* From half a metre of fall. */
      CHECK(fabs(hit.speed - sqrt(2.0 * 9.81 * 0.5)) < 0.1);
      CHECK(fabs(fabs(hit.normal.z) - 1.0) < 1e-9);
    }
  }
  tandem_contact contact;
  CHECK(begun == 1);
  CHECK(hits == 1);
  CHECK(tandem_world_contacts(world, TANDEM_TOUCHING, &contact, 1) == 1);
  CHECK(tandem_world_contacts(world, TANDEM_IN_SENSOR, NULL, 0) == 0);
  CHECK(contact.collider_a.index == collider.index || contact.collider_b.index == collider.index);
  CHECK(fabs(height(world, ball) - 0.5) < 1e-3);
  CHECK(!tandem_body_awake(world, ball));
  tandem_world_destroy(world);
}

static void hinge_with_a_motor_turns(void) {
  tandem_world* world = make_world(0);
  CHECK(tandem_world_set_gravity(world, (tandem_vec3){0, 0, 0}, NULL) == TANDEM_OK);
  const tandem_body wheel = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  tandem_joint_def def;
  tandem_joint joint;
  tandem_joint_def_init(&def, TANDEM_HINGE);
  def.b = wheel;
  CHECK(tandem_joint_add(world, &def, &joint, NULL) == TANDEM_OK);
  CHECK(tandem_joint_set_motor(world, joint, TANDEM_MOTOR_VELOCITY, 0.5, 100.0, NULL) == TANDEM_OK);
  for (int i = 0; i < 120; ++i) tandem_world_step(world, kStep, NULL, NULL);
  double angle = 0.0;
  int32_t broken = 1;
  CHECK(tandem_joint_position(world, joint, &angle, &broken, NULL) == TANDEM_OK);
  CHECK(fabs(angle - 1.0) < 0.02);
  CHECK(broken == 0);
  // Critical: 100 rad/s by its inertia; it is there after a second.
  const double inertia = 0.4 * 0.5;
  CHECK(tandem_joint_set_servo(world, joint, TANDEM_MOTOR_POSITION, 0.3, 100.0 * inertia,
                               20.0 * inertia, 50.0, NULL) == TANDEM_OK);
  for (int i = 0; i < 120; ++i) tandem_world_step(world, kStep, NULL, NULL);
  CHECK(tandem_joint_position(world, joint, &angle, &broken, NULL) == TANDEM_OK);
  CHECK(fabs(angle - 0.3) < 1e-3);
  tandem_world_destroy(world);
}

static void shapes_weigh_what_they_are(void) {
  tandem_shape shape;
  tandem_mass mass;
  tandem_error error;
  tandem_shape_init(&shape, TANDEM_BOX);
  shape.half_extents = (tandem_vec3){0.5, 1.0, 1.5};
  CHECK(tandem_shape_mass(&shape, 2.0, &mass, NULL) == TANDEM_OK);
  CHECK(fabs(mass.mass - 12.0) < 1e-12);
  CHECK(fabs(mass.inertia[0] - 12.0 * (2.0 * 2.0 + 3.0 * 3.0) / 12.0) < 1e-9);

  const tandem_vec3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tandem_shape_init(&shape, TANDEM_HULL);
  shape.points = corners;
  shape.point_count = 4;
  CHECK(tandem_shape_mass(&shape, 6.0, &mass, NULL) == TANDEM_OK);
  CHECK(fabs(mass.mass - 1.0) < 1e-12); /* a sixth of a cube */
  CHECK(fabs(mass.centre_of_mass.x - 0.25) < 1e-12);

  const double heights[4] = {0.0, 0.0, 0.0, 0.0};
  tandem_shape_init(&shape, TANDEM_HEIGHTS);
  shape.heights = heights;
  shape.columns = shape.rows = 2;
  CHECK(tandem_shape_mass(&shape, 1.0, &mass, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(error.text[0] != '\0');
}

static void snapshot_goes_on_as_before(void) {
  tandem_world* world = make_world(0);
  const tandem_body ground = add_body(world, TANDEM_STATIC, 0.0, 0.0);
  const tandem_body box = add_body(world, TANDEM_DYNAMIC, 0.1, 0.7);
  add_shape(world, ground, TANDEM_HALF_SPACE);
  add_shape(world, box, TANDEM_BOX);
  for (int i = 0; i < 20; ++i) tandem_world_step(world, kStep, NULL, NULL);
  size_t size = 0;
  CHECK(tandem_world_snapshot(world, NULL, &size, NULL) == TANDEM_TOO_SMALL);
  void* bytes = malloc(size);
  CHECK(tandem_world_snapshot(world, bytes, &size, NULL) == TANDEM_OK);
  for (int i = 0; i < 20; ++i) tandem_world_step(world, kStep, NULL, NULL);
  const uint64_t after = tandem_world_hash(world);
  CHECK(tandem_world_restore(world, bytes, size, NULL) == TANDEM_OK);
  CHECK(tandem_world_hash(world) != after);
  for (int i = 0; i < 20; ++i) tandem_world_step(world, kStep, NULL, NULL);
  CHECK(tandem_world_hash(world) == after);
  CHECK(tandem_world_restore(world, "nonsense", 8, NULL) == TANDEM_INVALID_ARGUMENT);
  free(bytes);
  tandem_world_destroy(world);
}

/* A ball that falls through a sensor comes in once and goes out once. */
static void sensor_tells_who_visits(void) {
  tandem_world* world = make_world(1);
  const tandem_body gate = add_body(world, TANDEM_STATIC, 0.0, 0.0);
  const tandem_body ball = add_body(world, TANDEM_DYNAMIC, 0.0, 2.0);
  tandem_collider_def def;
  tandem_collider_def_init(&def, TANDEM_SPHERE);
  def.body = gate;
  def.sensor = 1;
  tandem_collider sensor;
  CHECK(tandem_collider_add(world, &def, &sensor, NULL) == TANDEM_OK);
  const tandem_collider visitor = add_shape(world, ball, TANDEM_SPHERE);
  size_t begun = 0, ended = 0, inside = 0;
  for (int i = 0; i < 120; ++i) {
    tandem_contact visit;
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
    if (tandem_world_contacts(world, TANDEM_SENSOR_BEGUN, &visit, 1) == 1) {
      ++begun;
      CHECK(visit.collider_a.index == sensor.index);
      CHECK(visit.collider_b.index == visitor.index);
    }
    ended += tandem_world_contacts(world, TANDEM_SENSOR_ENDED, NULL, 0);
    inside += tandem_world_contacts(world, TANDEM_IN_SENSOR, NULL, 0);
  }
  CHECK(begun == 1);
  CHECK(ended == 1);
  CHECK(inside > 5);
  tandem_world_destroy(world);
}

enum { kWatched = 40 };

/* Contacts that begin, end and last after each of the next steps. */
static void watch(tandem_world* world, size_t seen[kWatched]) {
  for (int i = 0; i < kWatched; ++i) {
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
    seen[i] = 100 * tandem_world_contacts(world, TANDEM_BEGUN, NULL, 0) +
              10 * tandem_world_contacts(world, TANDEM_ENDED, NULL, 0) +
              tandem_world_contacts(world, TANDEM_TOUCHING, NULL, 0);
  }
}

/* A restored world reports the same events again. */
static void snapshot_brings_its_events_back(void) {
  tandem_world* world = make_world(1);
  const tandem_body ground = add_body(world, TANDEM_STATIC, 0.0, 0.0);
  const tandem_body ball = add_body(world, TANDEM_DYNAMIC, 0.0, 0.7);
  add_shape(world, ground, TANDEM_HALF_SPACE);
  add_shape(world, ball, TANDEM_SPHERE);
  CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
  char bytes[16384];
  size_t size = sizeof bytes;
  CHECK(tandem_world_snapshot(world, bytes, &size, NULL) == TANDEM_OK);
  size_t first[kWatched], second[kWatched];
  watch(world, first);
  CHECK(first[0] == 0 && first[kWatched - 1] == 1); /* it has come to rest in between */
  CHECK(tandem_world_restore(world, bytes, size, NULL) == TANDEM_OK);
  CHECK(tandem_world_contacts(world, TANDEM_TOUCHING, NULL, 0) == 0);
  watch(world, second);
  CHECK(memcmp(first, second, sizeof first) == 0);

  /* Bytes that were cut, or of a world without events, are none of this world's. */
  const uint64_t before = tandem_world_hash(world);
  for (size_t cut = 0; cut < size; cut += cut < 16 ? 1 : 37) {
    CHECK(tandem_world_restore(world, bytes, cut, NULL) == TANDEM_INVALID_ARGUMENT);
    CHECK(tandem_world_restore(world, bytes + size - cut, cut, NULL) == TANDEM_INVALID_ARGUMENT);
  }
  tandem_world* mute = make_world(0);
  size = sizeof bytes;
  CHECK(tandem_world_snapshot(mute, bytes, &size, NULL) == TANDEM_OK);
  CHECK(tandem_world_restore(world, bytes, size, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_world_hash(world) == before);
  CHECK(tandem_world_contacts(world, TANDEM_TOUCHING, NULL, 0) == 1);
  tandem_world_destroy(mute);
  tandem_world_destroy(world);
}

int main(void) {
  CHECK(tandem_c_version() == TANDEM_C_VERSION);
  falls_as_it_must();
  pushes_change_motion();
  many_are_where_each_is();
  comes_to_rest_on_the_ground();
  sensor_tells_who_visits();
  hinge_with_a_motor_turns();
  shapes_weigh_what_they_are();
  what_is_wrong_is_refused();
  snapshot_goes_on_as_before();
  snapshot_brings_its_events_back();
  queries_find();
  peers_share();
  parts_move();
  if (failures > 0) fprintf(stderr, "%d checks failed\n", failures);
  return failures > 0 ? 1 : 0;
}
