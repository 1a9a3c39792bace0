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

enum { kWatched = 40 };

/* What begins, ends and touches after each of the next steps. */
static void watch(tandem_world* world, size_t seen[kWatched]) {
  for (int i = 0; i < kWatched; ++i) {
    CHECK(tandem_world_step(world, kStep, NULL, NULL) == TANDEM_OK);
    seen[i] = 100 * tandem_world_contacts(world, TANDEM_BEGUN, NULL, 0) +
              10 * tandem_world_contacts(world, TANDEM_ENDED, NULL, 0) +
              tandem_world_contacts(world, TANDEM_TOUCHING, NULL, 0);
  }
}

/* What went back in time tells what happens as it told it before. */
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

/* A site: a world, a body in it, its peer. */
typedef struct site {
  tandem_world* world;
  tandem_body body;
  tandem_peer* peer;
} site;

static site make_site(tandem_transport* transport, double x) {
  site s;
  tandem_peer_def def;
  s.world = make_world(0);
  tandem_world_set_gravity(s.world, (tandem_vec3){0, 0, 0}, NULL);
  s.body = add_body(s.world, TANDEM_DYNAMIC, x, 0.0);
  tandem_peer_def_init(&def);
  def.authority_ramp = 0.0;
  s.peer = tandem_peer_create(s.world, transport, &def, NULL);
  CHECK(s.peer != NULL);
  CHECK(tandem_peer_share(s.peer, tandem_shared_id_of("cube"), s.body, 0, NULL) == TANDEM_OK);
  return s;
}

static void step_site(const site* s, int64_t now, int64_t next) {
  CHECK(tandem_peer_before_step(s->peer, now, NULL) == TANDEM_OK);
  CHECK(tandem_world_step(s->world, 1e-9 * (double)(next - now), NULL, NULL) == TANDEM_OK);
  CHECK(tandem_peer_after_step(s->peer, next, NULL) == TANDEM_OK);
}

static double place(const site* s) {
  tandem_state state;
  CHECK(tandem_body_state(s->world, s->body, &state, NULL) == TANDEM_OK);
  return state.pose.position.x;
}

static void destroy_site(site* s) {
  tandem_peer_destroy(s->peer);
  tandem_world_destroy(s->world);
}

/* Equal shares: both end in the middle. */
static void two_peers_meet_in_the_middle(void) {
  const tandem_link link = {.latency = 0.03};
  const int64_t start = 1000000000, step = 16666667;
  tandem_network* network = tandem_network_create(&link, 1, start, NULL);
  site a = make_site(tandem_network_transport(network, 1, NULL), 0.0);
  site b = make_site(tandem_network_transport(network, 2, NULL), 0.1);
  for (int64_t k = 0; k < 240; ++k) {
    CHECK(tandem_network_advance(network, start + k * step, NULL) == TANDEM_OK);
    step_site(&a, start + k * step, start + (k + 1) * step);
    step_site(&b, start + k * step, start + (k + 1) * step);
  }
  CHECK(fabs(place(&a) - place(&b)) < 1e-4);
  CHECK(fabs(place(&a) - 0.05) < 0.005);
  tandem_peer_stats stats;
  tandem_peer_get_stats(a.peer, &stats);
  CHECK(stats.updates_received > 200);
  CHECK(stats.packets_rejected == 0);

  /* A spring of one is felt by the other. */
  tandem_grab_def grab;
  uint32_t id = 0;
  tandem_grab_def_init(&grab);
  grab.body = tandem_shared_id_of("cube");
  grab.anchor = (tandem_vec3){1.0, 0.0, 0.0};
  CHECK(tandem_peer_grab(a.peer, &grab, &id, NULL) == TANDEM_OK);
  for (int64_t k = 240; k < 480; ++k) {
    tandem_network_advance(network, start + k * step, NULL);
    step_site(&a, start + k * step, start + (k + 1) * step);
    step_site(&b, start + k * step, start + (k + 1) * step);
  }
  CHECK(place(&b) > 0.9);
  CHECK(tandem_peer_release(a.peer, id, NULL) == TANDEM_OK);
  CHECK(tandem_peer_release(a.peer, id + 7, NULL) == TANDEM_INVALID_ARGUMENT);
  destroy_site(&a);
  destroy_site(&b);
  tandem_network_destroy(network);
}

/* A wire of the program's own: what one posts waits here for the other. */
enum { kSlots = 64, kBytes = 2048 };
typedef struct wire {
  struct end {
    uint64_t self, other;
    unsigned char bytes[kSlots][kBytes];
    size_t size[kSlots];
    int count;
    struct end* peer;
    int dropped;
  } ends[2];
} wire;

static int32_t wire_post(void* user, uint64_t to, const void* bytes, size_t size,
                         tandem_delivery delivery) {
  struct end* from = user;
  struct end* other = from->peer;
  (void)delivery;
  if (to != from->other || other->count == kSlots || size > kBytes) return 0;
  memcpy(other->bytes[other->count], bytes, size);
  other->size[other->count++] = size;
  return 1;
}

static void wire_drain(void* user, tandem_receive receive, void* inbox) {
  struct end* end = user;
  for (int i = 0; i < end->count; ++i) receive(inbox, end->other, end->bytes[i], end->size[i]);
  end->count = 0;
}

static void wire_peers(void* user, tandem_list_peer list, void* into) {
  struct end* end = user;
  list(into, end->other, !end->dropped);
}

static void wire_drop(void* user, uint64_t peer, const char* reason) {
  struct end* end = user;
  CHECK(peer == end->other);
  CHECK(reason != NULL && reason[0] != '\0');
  end->dropped = 1;
}

static tandem_transport* wire_transport(struct end* end) {
  const tandem_transport_def def = {.user = end,
                                    .self = end->self,
                                    .post = wire_post,
                                    .drain = wire_drain,
                                    .peers = wire_peers,
                                    .drop = wire_drop};
  return tandem_transport_create(&def, NULL);
}

static void a_transport_of_ones_own_carries_a_session(void) {
  wire* w = calloc(1, sizeof *w);
  w->ends[0].self = w->ends[1].other = 1;
  w->ends[1].self = w->ends[0].other = 2;
  w->ends[0].peer = &w->ends[1];
  w->ends[1].peer = &w->ends[0];
  tandem_transport* one = wire_transport(&w->ends[0]);
  tandem_transport* two = wire_transport(&w->ends[1]);
  const int64_t start = 1000000000, step = 16666667;
  site a = make_site(one, 0.0);
  site b = make_site(two, 0.1);
  for (int64_t k = 0; k < 240; ++k) {
    step_site(&a, start + k * step, start + (k + 1) * step);
    step_site(&b, start + k * step, start + (k + 1) * step);
  }
  CHECK(fabs(place(&a) - place(&b)) < 1e-4);
  /* Bytes that nobody can read cut their sender off, and the world goes on. */
  memset(w->ends[0].bytes[0], 0xff, 40);
  w->ends[0].size[0] = 40;
  w->ends[0].count = 1;
  step_site(&a, start + 240 * step, start + 241 * step);
  CHECK(w->ends[0].dropped == 1);
  destroy_site(&a);
  destroy_site(&b);
  tandem_transport_destroy(one);
  tandem_transport_destroy(two);
  const tandem_transport_def nothing = {.self = 1};
  CHECK(tandem_transport_create(&nothing, NULL) == NULL);
  free(w);
}

int main(void) {
  CHECK(tandem_c_version() == TANDEM_C_VERSION);
  falls_as_it_must();
  comes_to_rest_on_the_ground();
  hinge_with_a_motor_turns();
  shapes_weigh_what_they_are();
  what_is_wrong_is_refused();
  snapshot_goes_on_as_before();
  snapshot_brings_its_events_back();
  two_peers_meet_in_the_middle();
  a_transport_of_ones_own_carries_a_session();
  if (failures > 0) fprintf(stderr, "%d checks failed\n", failures);
  return failures > 0 ? 1 : 0;
}
