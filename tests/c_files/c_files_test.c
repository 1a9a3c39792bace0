/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Scene files from C: the bodies of a file are those that it says, and what is wrong has a name.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"
#include "tandem/c/tandem.h"

int failures = 0;

static const char kTable[] =
    "{\"gravity\": [0, 0, -1.62],\n"
    " \"bodies\": [\n"
    "  {\"name\": \"ground\", \"type\": \"static\", \"shape\": {\"type\": \"halfSpace\"}},\n"
    "  {\"name\": \"cup\", \"shape\": {\"type\": \"sphere\", \"radius\": 0.1}, \"mass\": 2,\n"
    "   \"position\": [0, 0, 5]},\n"
    "  {\"name\": \"door\", \"shape\": {\"type\": \"box\", \"halfExtents\": [0.4, 0.02, 1]},\n"
    "   \"mass\": 20, \"position\": [3.4, 0, 1.5]}],\n"
    " \"joints\": [{\"name\": \"hinge\", \"type\": \"hinge\", \"b\": \"door\",\n"
    "   \"at\": {\"position\": [3, 0, 1.5], \"axis\": [0, 0, 1]}}]}";

static const char kGltf[] =
    "{\"asset\": {\"version\": \"2.0\"},\n"
    " \"extensionsUsed\": [\"KHR_physics_rigid_bodies\", \"KHR_implicit_shapes\"],\n"
    " \"extensions\": {\"KHR_implicit_shapes\": {\"shapes\": [\n"
    "   {\"type\": \"sphere\", \"sphere\": {\"radius\": 0.5}}]}},\n"
    " \"scene\": 0, \"scenes\": [{\"nodes\": [0]}],\n"
    " \"nodes\": [{\"name\": \"ball\", \"translation\": [0, 2, 0], \"extensions\":\n"
    "   {\"KHR_physics_rigid_bodies\": {\"motion\": {\"mass\": 2},\n"
    "     \"collider\": {\"geometry\": {\"shape\": 0}}}}}]}";

static tandem_world* parse(const char* text, tandem_scene_file** file, tandem_error* error) {
  tandem_world_def def;
  tandem_world_def_init(&def);
  return tandem_scene_parse(TANDEM_SCENE_JSON, text, strlen(text), NULL, &def, file, error);
}

static tandem_vec3 position(const tandem_world* world, tandem_body body) {
  tandem_state state = {{{NAN, NAN, NAN}, {0, 0, 0, 1}}, {{0, 0, 0}, {0, 0, 0}}};
  CHECK(tandem_body_state(world, body, &state, NULL) == TANDEM_OK);
  return state.pose.position;
}

static void run(tandem_world* world, int steps) {
  for (int i = 0; i < steps; ++i) {
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
  }
}

/* Three bodies by their names, one joint, and the gravity of the moon. */
static void a_file_gives_its_bodies(void) {
  tandem_scene_file* file = NULL;
  tandem_error error;
  tandem_world* world = parse(kTable, &file, &error);
  CHECK(world != NULL && file != NULL);
  tandem_named_body bodies[3];
  CHECK(tandem_scene_file_bodies(file, bodies, 3) == 3);
  CHECK(strcmp(bodies[0].name, "ground") == 0 && strcmp(bodies[2].name, "door") == 0);
  tandem_body cup = TANDEM_NO_BODY;
  CHECK(tandem_scene_file_find_body(file, "cup", &cup, NULL) == TANDEM_OK);
  CHECK(cup.index == bodies[1].body.index);
  CHECK(tandem_scene_file_find_body(file, "saucer", &cup, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "name") != NULL && strstr(error.text, "saucer") != NULL);
  tandem_named_joint joint;
  tandem_joint hinge = {77, 77};
  CHECK(tandem_scene_file_joints(file, &joint, 1) == 1 && strcmp(joint.name, "hinge") == 0);
  CHECK(tandem_scene_file_find_joint(file, "hinge", &hinge, NULL) == TANDEM_OK);
  CHECK(hinge.index == joint.joint.index);
  CHECK(tandem_scene_file_find_joint(file, "lock", &hinge, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_scene_file_warnings(file, NULL, 0) == 0);

  /* A second of free fall, by the semi-implicit step of 4 substeps. */
  run(world, 60);
  CHECK(fabs(position(world, cup).z - (5.0 - 0.5 * 1.62 * (1.0 + 1.0 / 240.0))) < 1e-9);
  double turned = 0.0;
  CHECK(tandem_body_apply_impulse(world, bodies[2].body, (tandem_vec3){0, 20.0, 0}, NULL, NULL) ==
        TANDEM_OK);
  run(world, 30);
  CHECK(tandem_joint_position(world, hinge, &turned, NULL, NULL) == TANDEM_OK && turned > 0.1);

  const char more[] =
      "{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius\": 0.5}, "
      "\"position\": [0, 9, 3]}";
  tandem_body ball = TANDEM_NO_BODY;
  CHECK(tandem_scene_add_body(world, more, strlen(more), &ball, NULL) == TANDEM_OK);
  CHECK(fabs(position(world, ball).y - 9.0) < 1e-12);
  CHECK(tandem_scene_add_body(world, "{", 1, &ball, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "JSON") != NULL);
  tandem_world_destroy(world);
  /* Names outlive the world. */
  CHECK(tandem_scene_file_find_body(file, "cup", &cup, NULL) == TANDEM_OK);
  tandem_scene_file_destroy(file);
}

/* y is up there; a pose is that of the node. */
static void gltf_is_turned_upright(void) {
  tandem_world_def def;
  tandem_scene_file* file = NULL;
  tandem_error error;
  tandem_body ball;
  tandem_pose pose;
  tandem_world_def_init(&def);
  tandem_world* world =
      tandem_scene_parse(TANDEM_SCENE_GLTF, kGltf, strlen(kGltf), ".", &def, &file, &error);
  if (world == NULL) fprintf(stderr, "glTF: %s\n", error.text);
  CHECK(world != NULL);
  CHECK(tandem_scene_file_find_body(file, "ball", &ball, NULL) == TANDEM_OK);
  CHECK(fabs(position(world, ball).z - 2.0) < 1e-12);
  CHECK(tandem_scene_file_pose(file, "ball", &pose, NULL) == TANDEM_OK);
  CHECK(fabs(pose.position.z - 2.0) < 1e-12);
  CHECK(tandem_scene_file_pose(file, "bat", &pose, NULL) == TANDEM_INVALID_ARGUMENT);
  tandem_scene_file_destroy(file);
  run(world, 1); /* the world outlives its file */
  tandem_world_destroy(world);
  CHECK(tandem_scene_parse(TANDEM_SCENE_GLTF, kGltf, strlen(kGltf), NULL, &def, NULL, &error) ==
        NULL);
  CHECK(strstr(error.text, "folder") != NULL);
  CHECK(tandem_scene_parse((tandem_scene_format)17, kGltf, 1, NULL, &def, NULL, &error) == NULL);
  CHECK(strstr(error.text, "tandem_scene_format") != NULL && strstr(error.text, "17") != NULL);
}

/* A written file is read with the same bits of motion, and with its names. */
static void what_is_written_is_read_again(void) {
  tandem_scene_file *first = NULL, *second = NULL;
  tandem_error error;
  size_t size = 0;
  tandem_world* world = parse(kTable, &first, NULL);
  CHECK(tandem_scene_write(world, first, NULL, &size, &error) == TANDEM_TOO_SMALL && size > 100);
  char* text = malloc(size);
  CHECK(tandem_scene_write(world, first, text, &size, NULL) == TANDEM_OK);
  CHECK(strlen(text) == size - 1);
  tandem_world* again = parse(text, &second, NULL);
  run(world, 300);
  run(again, 300);
  CHECK(tandem_world_hash(world) == tandem_world_hash(again));
  tandem_body cup;
  CHECK(tandem_scene_file_find_body(second, "cup", &cup, NULL) == TANDEM_OK);
  CHECK(tandem_scene_write(world, second, text, &size, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "file") != NULL);
  size = 10;
  CHECK(tandem_scene_write(world, NULL, text, &size, NULL) == TANDEM_TOO_SMALL && size > 10);
  free(text);
  tandem_scene_file_destroy(first);
  tandem_scene_file_destroy(second);
  tandem_world_destroy(world);
  tandem_world_destroy(again);
}

static int write_file(const char* path, const char* text) {
  FILE* file = fopen(path, "wb");
  if (file == NULL) return 0;
  const int written = fputs(text, file) >= 0;
  return fclose(file) == 0 && written;
}

/* File, place, rule and value, however long the folders' names are. */
static void a_wrong_file_names_its_fault(void) {
  tandem_world_def def;
  tandem_error error;
  char path[512] = "./";
  tandem_world_def_init(&def);
  for (int i = 0; i < 130; ++i) strcat(path, "./");
  strcat(path, "c_files_test.json");
  CHECK(write_file(path, kTable));
  tandem_world* world = tandem_scene_load(path, &def, NULL, &error);
  CHECK(world != NULL);
  tandem_world_destroy(world);
  CHECK(write_file(path, "{\"bodies\": [{\"shape\": {\"type\": \"sphere\", \"radius\": -1}}]}"));
  CHECK(tandem_scene_load(path, &def, NULL, &error) == NULL);
  CHECK(error.result == TANDEM_INVALID_ARGUMENT);
  CHECK(strncmp(error.text, "c_files_test.json: /bodies/0/shape", 34) == 0);
  CHECK(strstr(error.text, "radius must be > 0") != NULL && strstr(error.text, "is -1") != NULL);
  CHECK(remove("c_files_test.json") == 0); /* paths of Windows have 260 characters at most */
  /* A text that is cut ends with a whole letter, here of two bytes. */
  char long_name[601] = "x";
  for (int i = 0; i < 299; ++i) strcat(long_name, "\xc3\xa4");
  CHECK(tandem_scene_load(long_name, &def, NULL, &error) == NULL);
  const size_t length = strlen(error.text);
  CHECK(length >= 254 && (error.text[length - 1] & 0x7f) == 0x24);
  CHECK(tandem_scene_load("there_is_none.json", &def, NULL, &error) == NULL);
  CHECK(error.result == TANDEM_INVALID_ARGUMENT &&
        strstr(error.text, "there_is_none.json") != NULL);

  tandem_scene_file* file = NULL;
  CHECK(parse("{\"bodies\": [{}]}", &file, &error) == NULL && file == NULL);
  CHECK(strstr(error.text, "/bodies/0") != NULL && strstr(error.text, "shape") != NULL);
  CHECK(tandem_scene_load(NULL, &def, NULL, &error) == NULL);
  CHECK(strstr(error.text, "path") != NULL);
  CHECK(tandem_scene_load("x", NULL, NULL, &error) == NULL);
  CHECK(tandem_scene_file_bodies(NULL, NULL, 3) == 0);
  CHECK(tandem_scene_file_joints(NULL, NULL, 3) == 0);
  tandem_scene_file_destroy(NULL);
}

int main(void) {
  a_file_gives_its_bodies();
  gltf_is_turned_upright();
  what_is_written_is_read_again();
  a_wrong_file_names_its_fault();
  if (failures == 0) printf("c_files: all claims hold\n");
  return failures == 0 ? 0 : 1;
}
