/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * What the tests in C# compare themselves with: layouts, and hashes of the same programs.
 */
#include "reference.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "tandem/c/tandem.h"

static void must(tandem_result result, const tandem_error* error) {
  if (result == TANDEM_OK) return;
  fprintf(stderr, "csharp_reference: %s\n", error->text);
  exit(1);
}

static tandem_world* make_world(void) {
  tandem_world_def def;
  tandem_error error;
  tandem_world_def_init(&def);
  tandem_world* world = tandem_world_create(&def, &error);
  must(world == NULL ? error.result : TANDEM_OK, &error);
  return world;
}

static tandem_body add(tandem_world* world, tandem_body_type type, const tandem_shape* shape,
                       double density, tandem_pose pose) {
  tandem_error error;
  tandem_body_def def;
  tandem_body_def_init(&def);
  def.type = type;
  def.pose = pose;
  if (type == TANDEM_DYNAMIC) {
    tandem_mass mass;
    must(tandem_shape_mass(shape, density, &mass, &error), &error);
    def.mass = mass.mass;
    for (int i = 0; i < 9; ++i) def.inertia[i] = mass.inertia[i];
  }
  tandem_body body;
  must(tandem_body_add(world, &def, &body, &error), &error);
  tandem_collider_def on;
  tandem_collider_def_init(&on, shape->kind);
  on.body = body;
  on.shape = *shape;
  tandem_collider collider;
  must(tandem_collider_add(world, &on, &collider, &error), &error);
  return body;
}

static tandem_pose at(double x, double y, double z) {
  return (tandem_pose){{x, y, z}, {0.0, 0.0, 0.0, 1.0}};
}

static void add_ground(tandem_world* world) {
  tandem_shape ground;
  tandem_shape_init(&ground, TANDEM_HALF_SPACE);
  ground.normal = (tandem_vec3){0.0, 0.0, 1.0};
  add(world, TANDEM_STATIC, &ground, 0.0, at(0.0, 0.0, 0.0));
}

static void step(tandem_world* world) {
  tandem_error error;
  must(tandem_world_step(world, 1.0 / 60.0, NULL, &error), &error);
}

/* docs/tutorial.md: a cube falls on the ground and stays there, by the same bits as in C++. */
static void falling(void) {
  uint64_t of_cpp[TUTORIAL_HASHES];
  tutorial_of_cpp(of_cpp);
  tandem_world* world = make_world();
  tandem_shape cube;
  add_ground(world);
  tandem_shape_init(&cube, TANDEM_BOX);
  cube.half_extents = (tandem_vec3){0.1, 0.1, 0.1};
  add(world, TANDEM_DYNAMIC, &cube, 250.0, at(0.0, 0.0, 1.0));
  for (int i = 0; i <= 120; ++i) {
    if (i % 30 == 0) {
      const uint64_t hash = tandem_world_hash(world);
      printf("hash falling %" PRIu64 "\n", hash);
      if (hash != of_cpp[i / 30]) {
        fprintf(stderr, "csharp_reference: step %d has another hash than in C++\n", i);
        exit(1);
      }
    }
    step(world);
  }
  tandem_world_destroy(world);
}

/* A crooked stack beside a door that a motor turns into it. */
static void stack(void) {
  tandem_world* world = make_world();
  tandem_error error;
  tandem_shape box, door;
  add_ground(world);
  tandem_shape_init(&box, TANDEM_BOX);
  box.half_extents = (tandem_vec3){0.2, 0.15, 0.1};
  for (int i = 0; i < 8; ++i) {
    add(world, TANDEM_DYNAMIC, &box, 400.0, at(0.01 * i, -0.02 * i, 0.1 + 0.21 * i));
  }
  tandem_shape_init(&door, TANDEM_CAPSULE);
  door.radius = 0.1;
  door.half_height = 0.4;
  const tandem_body leaf = add(world, TANDEM_DYNAMIC, &door, 700.0, at(0.8, 0.6, 0.7));
  tandem_joint_def def;
  tandem_joint joint;
  tandem_joint_def_init(&def, TANDEM_HINGE);
  def.b = leaf;
  def.anchor = (tandem_vec3){1.2, 0.6, 0.7};
  def.axis = (tandem_vec3){0.0, 0.0, 1.0};
  def.motor = TANDEM_MOTOR_VELOCITY;
  def.motor_target = 2.0;
  def.motor_max_force = 300.0;
  must(tandem_joint_add(world, &def, &joint, &error), &error);
  for (int i = 0; i < 240; ++i) {
    step(world);
    if (i % 60 == 59) printf("hash stack %" PRIu64 "\n", tandem_world_hash(world));
  }
  tandem_world_destroy(world);
}

int main(void) {
  printf("version %d\n", TANDEM_C_VERSION);
  print_layout();
  falling();
  stack();
  return 0;
}
