/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * What a binding may get wrong: each is named and changes nothing.
 */
#include <math.h>
#include <string.h>

#include "support.h"
#include "tandem/c/tandem.h"

/* Whether the call was refused with a text that has all of it. */
static int refused(tandem_result result, const tandem_error* error, const char* what,
                   const char* value) {
  return result == TANDEM_INVALID_ARGUMENT && error->result == result &&
         strstr(error->text, what) != NULL && strstr(error->text, value) != NULL;
}

static void what_is_wrong_is_named_and_changes_nothing(void) {
  tandem_world* world = make_world(0);
  tandem_error error;
  tandem_body_def def;
  tandem_body body = TANDEM_NO_BODY;
  tandem_body_def_init(&def);
  def.mass = -1.0;
  CHECK(tandem_body_add(world, &def, &body, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(error.result == TANDEM_INVALID_ARGUMENT);
  CHECK(strstr(error.text, "mass") != NULL);
  CHECK(!tandem_body_exists(world, body));
  CHECK(tandem_body_add(world, NULL, &body, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_body_add(NULL, &def, &body, NULL) == TANDEM_INVALID_ARGUMENT);

  const tandem_body real = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  CHECK(tandem_body_remove(world, real, NULL) == TANDEM_OK);
  const tandem_body next = add_body(world, TANDEM_DYNAMIC, 0.0, 5.0);
  tandem_state state;
  /* The old handle never names what came into its place. */
  CHECK(next.index == real.index);
  CHECK(tandem_body_state(world, real, &state, &error) == TANDEM_INVALID_ARGUMENT);

  const uint64_t before = tandem_world_hash(world);
  const tandem_pose nowhere = {{NAN, 0, 0}, {0, 0, 0, 1}};
  CHECK(tandem_body_set_pose(world, next, &nowhere, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_world_step(world, -1.0, NULL, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_world_step(world, NAN, NULL, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_world_hash(world) == before);
  def.mass = 1.0;
  def.type = (tandem_body_type)17;
  CHECK(tandem_body_add(world, &def, &body, &error) == TANDEM_INVALID_ARGUMENT);
  tandem_world_destroy(world);
  tandem_world_destroy(NULL);
}

static void handles_of_what_was_removed(void) {
  tandem_world* world = make_world(0);
  tandem_error error;
  const tandem_body body = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  const tandem_collider collider = add_shape(world, body, TANDEM_SPHERE);
  tandem_joint_def def;
  tandem_joint joint;
  double position = 0.0;
  tandem_joint_def_init(&def, TANDEM_BALL);
  def.b = body;
  CHECK(tandem_joint_add(world, &def, &joint, NULL) == TANDEM_OK);
  CHECK(refused(tandem_joint_set_motor(world, joint, TANDEM_MOTOR_VELOCITY, 1.0, 1.0, &error),
                &error, "joint", "hinge"));
  CHECK(tandem_body_remove(world, body, NULL) == TANDEM_OK);
  CHECK(!tandem_body_exists(world, body) && !tandem_body_awake(world, body));
  CHECK(refused(tandem_joint_position(world, joint, &position, NULL, &error), &error, "joint",
                "generation"));
  CHECK(refused(tandem_joint_remove(world, joint, &error), &error, "joint", "generation"));
  CHECK(tandem_collider_remove(world, collider, &error) == TANDEM_INVALID_ARGUMENT);
  const tandem_body never = {123456, 7};
  CHECK(refused(tandem_body_remove(world, never, &error), &error, "123456", "7"));
  CHECK(refused(tandem_joint_add(world, &def, &joint, &error), &error, "b", "generation"));
  tandem_world_destroy(world);
}

static void values_that_no_enum_lists(void) {
  tandem_world* world = make_world(1);
  tandem_error error;
  const tandem_body body = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  tandem_body made;
  tandem_body_def body_def;
  tandem_body_def_init(&body_def);
  body_def.type = (tandem_body_type)17;
  CHECK(
      refused(tandem_body_add(world, &body_def, &made, &error), &error, "tandem_body_type", "17"));
  tandem_joint joint;
  tandem_joint_def joint_def;
  tandem_joint_def_init(&joint_def, (tandem_joint_kind)17);
  joint_def.b = body;
  CHECK(refused(tandem_joint_add(world, &joint_def, &joint, &error), &error, "tandem_joint_kind",
                "17"));
  tandem_joint_def_init(&joint_def, TANDEM_SLIDER);
  joint_def.b = body;
  joint_def.motor = (tandem_motor_mode)-1;
  CHECK(refused(tandem_joint_add(world, &joint_def, &joint, &error), &error, "tandem_motor_mode",
                "-1"));
  tandem_collider collider;
  tandem_collider_def collider_def;
  tandem_collider_def_init(&collider_def, (tandem_shape_kind)17);
  collider_def.body = body;
  CHECK(refused(tandem_collider_add(world, &collider_def, &collider, &error), &error,
                "tandem_shape_kind", "17"));
  CHECK(tandem_world_contacts(world, (tandem_contact_list)17, NULL, 0) == 0);
  tandem_world_destroy(world);
}

/* -1 of a language whose sizes have a sign. */
static void counts_beyond_all_memory(void) {
  const tandem_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const uint32_t triangles[3] = {0, 1, 2};
  tandem_shape shape;
  tandem_mass mass;
  tandem_error error;
  tandem_shape_init(&shape, TANDEM_HULL);
  shape.points = points;
  shape.point_count = (size_t)-1;
  CHECK(refused(tandem_shape_mass(&shape, 1.0, &mass, &error), &error, "point_count", "2^28"));
  tandem_shape_init(&shape, TANDEM_MESH);
  shape.points = points;
  shape.point_count = 4;
  shape.triangles = triangles;
  shape.triangle_count = (size_t)-1;
  CHECK(refused(tandem_shape_mass(&shape, 1.0, &mass, &error), &error, "triangle_count", "2^28"));
  const double heights[1] = {0.0};
  tandem_shape_init(&shape, TANDEM_HEIGHTS);
  shape.heights = heights;
  shape.columns = shape.rows = UINT32_MAX;
  CHECK(refused(tandem_shape_mass(&shape, 1.0, &mass, &error), &error, "columns", "16384"));
}

static void times_that_no_session_has(void) {
  const tandem_link link = {.latency = 0.03};
  tandem_error error;
  CHECK(tandem_network_create(&link, 1, INT64_MAX, &error) == NULL);
  CHECK(refused(error.result, &error, "start_ns", "9223372036854775807"));
  CHECK(tandem_network_create(&link, 1, INT64_MIN, &error) == NULL);
  tandem_network* network = tandem_network_create(&link, 1, 1000, &error);
  CHECK(network != NULL);
  CHECK(refused(tandem_network_advance(network, INT64_MAX, &error), &error, "time_ns",
                "9223372036854775807"));
  CHECK(refused(tandem_network_advance(network, 999, &error), &error, "time", "999"));
  CHECK(tandem_network_transport(network, 0, &error) == NULL);
  tandem_world* world = make_world(0);
  CHECK(refused(tandem_world_step(world, 1e7, NULL, &error), &error, "dt", "1e6"));
  tandem_peer_def def;
  tandem_peer_def_init(&def);
  def.tolerance = -1.0;
  CHECK(tandem_peer_create(world, tandem_network_transport(network, 1, NULL), &def, &error) ==
        NULL);
  CHECK(refused(error.result, &error, "tolerance", "-1"));
  tandem_peer_def_init(&def);
  def.replay_budget = 0.5;
  CHECK(tandem_peer_create(world, tandem_network_transport(network, 1, NULL), &def, &error) ==
        NULL);
  CHECK(refused(error.result, &error, "budget", "0.5"));
  tandem_peer_def_init(&def);
  def.compact = 1;
  def.kbit_per_s = 64.0;
  tandem_peer* peer =
      tandem_peer_create(world, tandem_network_transport(network, 1, NULL), &def, NULL);
  CHECK(peer != NULL);
  CHECK(refused(tandem_peer_before_step(peer, 0, &error), &error, "now_ns", "0"));
  CHECK(refused(tandem_peer_after_step(peer, INT64_MAX, &error), &error, "now_ns",
                "9223372036854775807"));
  CHECK(tandem_peer_create(world, tandem_network_transport(network, 2, NULL), &def, &error) ==
        NULL);
  CHECK(refused(error.result, &error, "world", "peer"));
  tandem_peer_destroy(peer);
  tandem_world_destroy(world);
  tandem_network_destroy(network);
}

static unsigned char nonsense[70000];

static int32_t nothing_posted(void* user, uint64_t to, const void* bytes, size_t size,
                              tandem_delivery delivery) {
  (void)user, (void)to, (void)bytes, (void)delivery;
  CHECK(size > 0 && size <= 61440);
  return 0;
}

static void nonsense_drained(void* user, tandem_receive receive, void* inbox) {
  (void)user;
  receive(NULL, 2, nonsense, 4);
  receive(inbox, 0, nonsense, 4);
  receive(inbox, 2, NULL, 4);
  receive(inbox, 2, nonsense, sizeof nonsense);
  receive(inbox, 2, NULL, 0); /* the only one that is a packet, if not one of ours */
}

static void peers_in_no_order(void* user, tandem_list_peer list, void* into) {
  (void)user;
  list(NULL, 2, 1);
  list(into, 0, 1);
  list(into, 9, 1);
  list(into, 2, 1);
  list(into, 2, 0);
  list(into, 9, 1);
}

static void a_transport_that_makes_things_up(void) {
  const tandem_transport_def wire = {
      .self = 1, .post = nothing_posted, .drain = nonsense_drained, .peers = peers_in_no_order};
  tandem_transport* transport = tandem_transport_create(&wire, NULL);
  tandem_world* world = make_world(0);
  tandem_peer_def def;
  tandem_peer_def_init(&def);
  tandem_peer* peer = tandem_peer_create(world, transport, &def, NULL);
  CHECK(tandem_peer_share(peer, tandem_shared_id_of("cube"),
                          add_body(world, TANDEM_DYNAMIC, 0.0, 0.0), 0, NULL) == TANDEM_OK);
  for (int64_t now = 1000000000; now < 1500000000; now += 16666667) {
    CHECK(tandem_peer_before_step(peer, now, NULL) == TANDEM_OK);
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
    CHECK(tandem_peer_after_step(peer, now + 16666667, NULL) == TANDEM_OK);
  }
  tandem_peer_stats stats;
  tandem_peer_get_stats(peer, &stats);
  CHECK(stats.packets_received > 0 && stats.packets_rejected == stats.packets_received);
  CHECK(stats.updates_received == 0 && stats.bytes_sent == 0);
  tandem_peer_destroy(peer);
  tandem_world_destroy(world);
  tandem_transport_destroy(transport);
}

/* Too short for what must be said at once, or longer than what a peer reads. */
static void packets_of_no_use(void) {
  const struct {
    size_t max_packet;
    const char* text;
  } wrong[] = {
      {1, ", is 1"}, {511, ", is 511"}, {61441, ", is 61441"}, {(size_t)-1, "max_packet must be "}};
  const size_t right[] = {0, 512, 61440};
  tandem_transport_def wire = {
      .self = 1, .post = nothing_posted, .drain = nonsense_drained, .peers = peers_in_no_order};
  tandem_error error;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    wire.max_packet = wrong[i].max_packet;
    CHECK(tandem_transport_create(&wire, &error) == NULL);
    CHECK(refused(error.result, &error, wrong[i].text, "0 or from 512 to 61440"));
  }
  for (size_t i = 0; i < sizeof right / sizeof *right; ++i) {
    wire.max_packet = right[i];
    tandem_transport* transport = tandem_transport_create(&wire, &error);
    CHECK(transport != NULL);
    tandem_transport_destroy(transport);
  }
}

/* The text has room for 255 characters: rule and value must not get lost in digits. */
static void values_of_any_size(void) {
  tandem_error error;
  tandem_world_def def;
  tandem_world_def_init(&def);
  def.sleep_after = 1e300;
  CHECK(tandem_world_create(&def, &error) == NULL);
  CHECK(refused(error.result, &error, "sleep_after", "1e+300"));
  CHECK(strstr(error.text, "must be from 0 to 1000000") != NULL);
  tandem_world* world = make_world(0);
  CHECK(refused(tandem_world_step(world, -1e-12, NULL, &error), &error, "dt", "-1e-12"));
  CHECK(refused(tandem_world_step(world, 1e300, NULL, &error), &error, "1e+300", "1e6 s"));
  tandem_world_destroy(world);
}

/* Of nothing, and to nowhere. */
static void nothing_at_all(void) {
  tandem_error error;
  tandem_world* world = make_world(0);
  const tandem_body body = add_body(world, TANDEM_DYNAMIC, 0.0, 0.0);
  CHECK(tandem_world_create(NULL, &error) == NULL && error.result == TANDEM_INVALID_ARGUMENT);
  CHECK(refused(tandem_world_step(NULL, kStep, NULL, &error), &error, "world", "null"));
  CHECK(refused(tandem_body_state(world, body, NULL, &error), &error, "state", "null"));
  CHECK(refused(tandem_body_set_pose(world, body, NULL, &error), &error, "pose", "null"));
  CHECK(refused(tandem_world_snapshot(world, NULL, NULL, &error), &error, "size", "null"));
  CHECK(refused(tandem_world_restore(world, NULL, 8, &error), &error, "bytes", "null"));
  CHECK(refused(tandem_peer_before_step(NULL, 1, &error), &error, "peer", "null"));
  CHECK(tandem_world_hash(NULL) == 0);
  CHECK(tandem_world_contacts(world, TANDEM_BEGUN, NULL, 7) == 0); /* none are collected */
  CHECK(tandem_world_hits(NULL, NULL, 7) == 0);
  tandem_peer_stats stats;
  memset(&stats, 0xff, sizeof stats);
  tandem_peer_get_stats(NULL, &stats);
  CHECK(stats.packets_received == 0 && stats.bodies_placed == 0);
  tandem_peer_get_stats(NULL, NULL);
  tandem_peer_destroy(NULL);
  tandem_network_destroy(NULL);
  tandem_transport_destroy(NULL);
  tandem_world_destroy(world);
}

void what_is_wrong_is_refused(void) {
  what_is_wrong_is_named_and_changes_nothing();
  handles_of_what_was_removed();
  values_that_no_enum_lists();
  counts_beyond_all_memory();
  times_that_no_session_has();
  values_of_any_size();
  a_transport_that_makes_things_up();
  packets_of_no_use();
  nothing_at_all();
}
