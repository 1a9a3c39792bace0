/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Characters, cars, ropes, cloth and ragdolls: where they end up is what their numbers say.
 */
#include <math.h>
#include <string.h>

#include "support.h"
#include "tandem/c/tandem.h"

static const double kG = 9.81;

static tandem_world* world_with_ground(tandem_body* ground) {
  tandem_world* world = make_world(0);
  *ground = add_body(world, TANDEM_STATIC, 0.0, 0.0);
  tandem_collider_def def;
  tandem_collider collider;
  tandem_collider_def_init(&def, TANDEM_HALF_SPACE);
  def.body = *ground;
  def.friction = 0.9;
  CHECK(tandem_collider_add(world, &def, &collider, NULL) == TANDEM_OK);
  return world;
}

static tandem_state state_of(const tandem_world* world, tandem_body body) {
  tandem_state state;
  memset(&state, 0, sizeof state);
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  return state;
}

static void run(tandem_world* world, double seconds) {
  for (int i = 0; i < (int)(seconds * 60.0 + 0.5); ++i) {
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
  }
}

static int none_exists(const tandem_world* world, const tandem_body* bodies, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (tandem_body_exists(world, bodies[i])) return 0;
  }
  return 1;
}

static void a_character_stands_walks_and_jumps(void) {
  tandem_body ground;
  tandem_world* world = world_with_ground(&ground);
  tandem_character_def def;
  tandem_character_state state;
  tandem_error error;
  tandem_character_def_init(&def);
  def.mass = 0.0;
  CHECK(tandem_character_create(world, &def, &error) == NULL);
  CHECK(strstr(error.text, "mass") != NULL && strstr(error.text, "> 0") != NULL);
  tandem_character_def_init(&def);
  tandem_character* hero = tandem_character_create(world, &def, &error);
  CHECK(hero != NULL);
  const double stands = def.half_height + def.radius + def.padding;
  const tandem_vec3 still = {0, 0, 0}, ahead = {2.0, 0, 0};
  for (int i = 0; i < 60; ++i) {
    CHECK(tandem_character_walk(hero, still, kStep, NULL) == TANDEM_OK);
    tandem_world_step(world, kStep, NULL, NULL);
  }
  CHECK(tandem_character_get_state(hero, &state, NULL) == TANDEM_OK);
  CHECK(state.footing == TANDEM_ON_GROUND && state.ground.index == ground.index);
  CHECK(fabs(state.ground_normal.z - 1.0) < 1e-9);
  CHECK(fabs(state_of(world, state.body).pose.position.z - stands) < 0.01);
  for (int i = 0; i < 60; ++i) {
    CHECK(tandem_character_walk(hero, ahead, kStep, NULL) == TANDEM_OK);
    tandem_world_step(world, kStep, NULL, NULL);
  }
  CHECK(fabs(state_of(world, state.body).pose.position.x - 2.0) < 0.1);
  CHECK(tandem_character_jump(hero, 4.0, NULL) == TANDEM_OK);
  double top = 0.0;
  for (int i = 0; i < 60; ++i) {
    CHECK(tandem_character_walk(hero, still, kStep, NULL) == TANDEM_OK);
    tandem_world_step(world, kStep, NULL, NULL);
    top = fmax(top, state_of(world, state.body).pose.position.z);
    CHECK(tandem_character_get_state(hero, &state, NULL) == TANDEM_OK);
    CHECK(i != 10 || (state.footing == TANDEM_IN_AIR && state.ground.index == 0xffffffffu));
  }
  CHECK(fabs(top - stands - 4.0 * 4.0 / (2.0 * kG)) < 0.05);
  CHECK(tandem_character_walk(hero, (tandem_vec3){NAN, 0, 0}, kStep, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_character_jump(hero, -1.0, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_body_remove(world, state.body, NULL) == TANDEM_OK);
  CHECK(tandem_character_walk(hero, still, kStep, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "character") != NULL);
  tandem_character_destroy(hero);
  tandem_world_destroy(world);
}

/* The wheels' rotation gives the distance, and their speed is top_speed. */
static void a_car_rolls_as_far_as_its_wheels_turn(void) {
  tandem_body ground;
  tandem_world* world = world_with_ground(&ground);
  tandem_car_def def;
  tandem_error error;
  tandem_car_def_init(&def);
  def.wheelbase = -1.0;
  CHECK(tandem_car_create(world, &def, &error) == NULL);
  CHECK(strstr(error.text, "wheelbase") != NULL && strstr(error.text, "-1") != NULL);
  tandem_car_def_init(&def);
  def.top_speed = 10.0;
  tandem_car* car = tandem_car_create(world, &def, &error);
  CHECK(car != NULL);
  tandem_body bodies[5];
  CHECK(tandem_car_bodies(car, NULL, 0) == 5 && tandem_car_bodies(car, bodies, 5) == 5);
  CHECK(tandem_car_drive(car, 2.0, 0.0, 0.0, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "throttle") != NULL);
  CHECK(tandem_car_drive(car, 1.0, 0.0, 0.0, NULL) == TANDEM_OK);
  run(world, 10.0);
  CHECK(fabs(tandem_car_speed(car) - 10.0) < 0.5);
  const double begin = state_of(world, bodies[0]).pose.position.x;
  double rolled = 0.0;
  for (int i = 0; i < 300; ++i) {
    run(world, kStep);
    rolled += def.wheel_radius * state_of(world, bodies[3]).twist.angular.y * kStep;
  }
  const double way = state_of(world, bodies[0]).pose.position.x - begin;
  CHECK(fabs(way - rolled) < 0.02 * way && fabs(way - 50.0) < 2.5);
  CHECK(tandem_car_drive(car, 0.0, 0.0, 1.0, NULL) == TANDEM_OK);
  run(world, 5.0);
  CHECK(fabs(tandem_car_speed(car)) < 0.1);
  CHECK(tandem_body_remove(world, bodies[2], NULL) == TANDEM_OK);
  CHECK(tandem_car_drive(car, 1.0, 0.0, 0.0, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "car") != NULL);
  tandem_car_destroy(car);
  CHECK(none_exists(world, bodies, 5) && tandem_body_exists(world, ground));
  tandem_world_destroy(world);
}

/* Laid out level it swings until it hangs straight down; let go, it falls. */
static void a_rope_hangs_by_its_length(void) {
  tandem_world* world = make_world(0);
  const tandem_body hook = add_body(world, TANDEM_STATIC, 0.0, 3.0);
  tandem_rope_def def;
  tandem_error error;
  tandem_rope_def_init(&def);
  def.from = (tandem_vec3){0.0, 0.0, 3.0};
  def.to = (tandem_vec3){1.5, 0.0, 3.0};
  def.damping = 2.0;
  def.length = 1.0;
  CHECK(tandem_rope_create(world, &def, &error) == NULL);
  CHECK(strstr(error.text, "length") != NULL && strstr(error.text, "distance") != NULL);
  def.length = 0.0;
  tandem_rope* rope = tandem_rope_create(world, &def, &error);
  CHECK(rope != NULL);
  tandem_body bodies[20];
  tandem_attachment held = {0};
  CHECK(tandem_rope_bodies(rope, bodies, 20) == 20);
  CHECK(tandem_rope_attach(rope, 20, hook, &held, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "particle") != NULL && strstr(error.text, "20") != NULL);
  CHECK(tandem_rope_attach(rope, 0, hook, &held, NULL) == TANDEM_OK && held.number != 0);
  run(world, 20.0);
  const tandem_vec3 low = state_of(world, bodies[19]).pose.position;
  CHECK(fabs(low.x) < 0.02 && fabs(low.z - 1.5) < 0.01);
  CHECK(tandem_attachment_remove(world, held, NULL) == TANDEM_OK);
  CHECK(tandem_attachment_remove(world, held, NULL) == TANDEM_INVALID_ARGUMENT);
  /* By t seconds at a drag of c per second: g / c (t - (1 - exp(-c t)) / c). */
  run(world, 1.0);
  const double fallen = kG / 2.0 * (1.0 - (1.0 - exp(-2.0)) / 2.0);
  CHECK(fabs(low.z - state_of(world, bodies[19]).pose.position.z - fallen) < 0.1);
  tandem_rope_destroy(rope);
  CHECK(none_exists(world, bodies, 20));
  tandem_world_destroy(world);
}

static void a_cloth_hangs_by_its_height(void) {
  enum { kColumns = 8, kRows = 12, kCount = kColumns * kRows };
  tandem_world* world = make_world(0);
  const tandem_body rail = add_body(world, TANDEM_STATIC, 0.0, 3.0);
  tandem_cloth_def def;
  tandem_error error;
  tandem_cloth_def_init(&def);
  def.pose = (tandem_pose){{0.0, 0.0, 3.0}, {-sqrt(0.5), 0.0, 0.0, sqrt(0.5)}}; /* y is down */
  def.width = 0.8;
  def.height = 1.2;
  def.columns = 1;
  CHECK(tandem_cloth_create(world, &def, &error) == NULL);
  CHECK(strstr(error.text, "columns") != NULL);
  def.columns = kColumns;
  def.rows = kRows;
  tandem_cloth* cloth = tandem_cloth_create(world, &def, &error);
  CHECK(cloth != NULL);
  tandem_body bodies[kCount], handle;
  tandem_attachment held = {0};
  CHECK(tandem_cloth_bodies(cloth, bodies, kCount) == kCount);
  for (int i = 0; i < kColumns; ++i) {
    CHECK(tandem_cloth_attach(cloth, i, 0, rail, &held, NULL) == TANDEM_OK && held.number != 0);
  }
  CHECK(tandem_cloth_attach(cloth, kColumns, 0, rail, NULL, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_cloth_tether(cloth, NULL) == TANDEM_OK);
  CHECK(tandem_cloth_add_handle(cloth, 2.0, 0.5, 0.3, 0.3, &handle, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_cloth_add_handle(cloth, 0.5, 0.5, 0.3, 0.3, &handle, NULL) == TANDEM_OK);
  run(world, 5.0);
  for (int i = 0; i < kColumns; ++i) {
    CHECK(fabs(state_of(world, bodies[i]).pose.position.z - 3.0) < 1e-3);
    CHECK(fabs(state_of(world, bodies[kCount - 1 - i]).pose.position.z - 1.8) < 0.02);
  }
  CHECK(fabs(state_of(world, handle).pose.position.z - 2.4) < 0.03);
  tandem_cloth_destroy(cloth);
  CHECK(none_exists(world, bodies, kCount) && !tandem_body_exists(world, handle));
  tandem_world_destroy(world);
}

/* Upright it is as tall as it was said; then it lies. */
static void a_ragdoll_falls_over(void) {
  tandem_body ground, bodies[11];
  tandem_world* world = world_with_ground(&ground);
  tandem_ragdoll_def def;
  tandem_error error;
  tandem_ragdoll_def_init(&def);
  def.height = 0.0;
  CHECK(tandem_ragdoll_create(world, &def, &error) == NULL);
  CHECK(strstr(error.text, "height") != NULL && strstr(error.text, "> 0") != NULL);
  def.height = 2.0;
  def.pose.position.z = 0.01;
  tandem_ragdoll* doll = tandem_ragdoll_create(world, &def, &error);
  CHECK(doll != NULL && tandem_ragdoll_bodies(doll, bodies, 11) == 11);
  /* A head is a tenth of the height or so, and its middle below the top. */
  const double head = state_of(world, bodies[2]).pose.position.z;
  CHECK(head > 1.7 && head < 2.0);
  CHECK(tandem_body_apply_impulse(world, bodies[2], (tandem_vec3){10.0, 3.0, 0}, NULL, NULL) ==
        TANDEM_OK);
  run(world, 5.0);
  for (int i = 0; i < 11; ++i) {
    const double z = state_of(world, bodies[i]).pose.position.z;
    CHECK(z > 0.0 && z < 0.6);
  }
  tandem_ragdoll_destroy(doll);
  CHECK(none_exists(world, bodies, 11));
  tandem_world_destroy(world);
}

static void no_part_at_all(void) {
  tandem_error error;
  CHECK(tandem_rope_create(NULL, NULL, &error) == NULL);
  CHECK(tandem_rope_bodies(NULL, NULL, 3) == 0 && tandem_car_bodies(NULL, NULL, 3) == 0);
  CHECK(tandem_cloth_bodies(NULL, NULL, 3) == 0 && tandem_ragdoll_bodies(NULL, NULL, 3) == 0);
  CHECK(tandem_car_speed(NULL) == 0.0);
  CHECK(tandem_character_get_state(NULL, NULL, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "character") != NULL);
  tandem_rope_def_init(NULL);
  tandem_rope_destroy(NULL);
  tandem_cloth_destroy(NULL);
  tandem_car_destroy(NULL);
  tandem_character_destroy(NULL);
  tandem_ragdoll_destroy(NULL);
}

void parts_move(void) {
  a_character_stands_walks_and_jumps();
  a_car_rolls_as_far_as_its_wheels_turn();
  a_rope_hangs_by_its_length();
  a_cloth_hangs_by_its_height();
  a_ragdoll_falls_over();
  no_part_at_all();
}
