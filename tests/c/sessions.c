/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Peers that share bodies, over a network of the library's and over a transport of one's own.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"
#include "tandem/c/tandem.h"

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

/* A kick of one is a kick of both; what does nothing, or is no number, is refused. */
static void an_act_counts_at_both(void) {
  const tandem_link link = {.latency = 0.03};
  const int64_t start = 1000000000, step = 16666667;
  tandem_network* network = tandem_network_create(&link, 1, start, NULL);
  site a = make_site(tandem_network_transport(network, 1, NULL), 0.0);
  site b = make_site(tandem_network_transport(network, 2, NULL), 0.0);
  tandem_act_def act;
  tandem_act_def_init(&act);
  act.body = tandem_shared_id_of("cube");
  CHECK(tandem_peer_act(a.peer, &act, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_peer_act(a.peer, NULL, NULL) == TANDEM_INVALID_ARGUMENT);
  act.sets_twist = 1;
  act.twist.linear.x = 0.5;
  for (int64_t k = 0; k < 120; ++k) {
    const int64_t now = start + k * step;
    tandem_network_advance(network, now, NULL);
    if (k == 60) CHECK(tandem_peer_act(a.peer, &act, NULL) == TANDEM_OK);
    step_site(&a, now, now + step);
    step_site(&b, now, now + step);
  }
  CHECK(fabs(place(&a) - 0.5) < 0.02);
  CHECK(fabs(place(&b) - 0.5) < 0.02);
  act.impulse.x = NAN;
  CHECK(tandem_peer_act(a.peer, &act, NULL) == TANDEM_INVALID_ARGUMENT);
  destroy_site(&a);
  destroy_site(&b);
  tandem_network_destroy(network);
}

/* A hand that moves takes its body along at both; once it has left it holds nothing. */
static void a_hand_moves_and_leaves(void) {
  const tandem_link link = {.latency = 0.03};
  const int64_t start = 1000000000, step = 16666667;
  tandem_network* network = tandem_network_create(&link, 1, start, NULL);
  site a = make_site(tandem_network_transport(network, 1, NULL), 0.0);
  site b = make_site(tandem_network_transport(network, 2, NULL), 0.0);
  tandem_grab_def grab;
  uint32_t id = 0;
  tandem_grab_def_init(&grab);
  grab.body = tandem_shared_id_of("cube");
  CHECK(tandem_peer_grab(a.peer, &grab, &id, NULL) == TANDEM_OK);
  for (int64_t k = 0; k < 240; ++k) {
    const int64_t now = start + k * step;
    tandem_network_advance(network, now, NULL);
    const tandem_vec3 hand = {k < 60 ? (double)k / 60.0 : 1.0, 0.0, 0.0};
    CHECK(tandem_peer_move(a.peer, id, hand, now, NULL) == TANDEM_OK);
    step_site(&a, now, now + step);
    step_site(&b, now, now + step);
  }
  CHECK(fabs(place(&a) - 1.0) < 0.01 && fabs(place(&b) - 1.0) < 0.01);

  /* Neither hears of the other's body any more: pushed away, it does not come back. */
  CHECK(tandem_peer_leave(a.peer, start + 240 * step, NULL) == TANDEM_OK);
  CHECK(tandem_peer_unshare(b.peer, grab.body, NULL) == TANDEM_OK);
  CHECK(tandem_peer_unshare(b.peer, grab.body, NULL) == TANDEM_INVALID_ARGUMENT);
  const tandem_pose away = {{3.0, 0.0, 0.0}, {0, 0, 0, 1}};
  const tandem_twist still = {{0, 0, 0}, {0, 0, 0}};
  CHECK(tandem_body_set_pose(b.world, b.body, &away, NULL) == TANDEM_OK);
  CHECK(tandem_body_set_twist(b.world, b.body, &still, NULL) == TANDEM_OK);
  for (int64_t k = 240; k < 300; ++k) {
    tandem_network_advance(network, start + k * step, NULL);
    step_site(&b, start + k * step, start + (k + 1) * step);
  }
  CHECK(fabs(place(&b) - 3.0) < 1e-9);
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
    size_t max_packet, longest; /* bytes: what is said, and of what was posted */
  } ends[2];
} wire;

static int32_t wire_post(void* user, uint64_t to, const void* bytes, size_t size,
                         tandem_delivery delivery) {
  struct end* from = user;
  struct end* other = from->peer;
  (void)delivery;
  if (size > from->longest) from->longest = size;
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
                                    .drop = wire_drop,
                                    .max_packet = end->max_packet};
  return tandem_transport_create(&def, NULL);
}

static wire* make_wire(size_t max_packet) {
  wire* w = calloc(1, sizeof *w);
  w->ends[0].self = w->ends[1].other = 1;
  w->ends[1].self = w->ends[0].other = 2;
  w->ends[0].peer = &w->ends[1];
  w->ends[1].peer = &w->ends[0];
  w->ends[0].max_packet = w->ends[1].max_packet = max_packet;
  return w;
}

static void a_transport_of_ones_own_carries_a_session(void) {
  wire* w = make_wire(0);
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

/* Twenty bodies are too much for one packet of 512 bytes, and so are ten springs. */
static void packets_are_no_longer_than_was_said(void) {
  enum { kShared = 20, kHeld = 10, kMax = 512 };
  wire* w = make_wire(kMax);
  tandem_transport* transports[2] = {wire_transport(&w->ends[0]), wire_transport(&w->ends[1])};
  site sites[2];
  tandem_body bodies[2][kShared];
  for (int s = 0; s < 2; ++s) {
    sites[s] = make_site(transports[s], 0.0);
    for (int i = 0; i < kShared; ++i) {
      const char name[2] = {(char)('a' + i), 0};
      bodies[s][i] = add_body(sites[s].world, TANDEM_DYNAMIC, 0.0, 3.0 * (i + 1));
      CHECK(tandem_peer_share(sites[s].peer, tandem_shared_id_of(name), bodies[s][i], 0, NULL) ==
            TANDEM_OK);
    }
  }
  for (int i = 0; i < kHeld; ++i) {
    const char name[2] = {(char)('a' + i), 0};
    tandem_grab_def grab;
    uint32_t id = 0;
    tandem_grab_def_init(&grab);
    grab.body = tandem_shared_id_of(name);
    grab.anchor = (tandem_vec3){1.0, 0.0, 3.0 * (i + 1)};
    CHECK(tandem_peer_grab(sites[0].peer, &grab, &id, NULL) == TANDEM_OK);
  }
  const int64_t start = 1000000000, step = 16666667;
  for (int64_t k = 0; k < 240; ++k) {
    for (int s = 0; s < 2; ++s) step_site(&sites[s], start + k * step, start + (k + 1) * step);
  }
  for (int s = 0; s < 2; ++s) {
    CHECK(w->ends[s].longest <= kMax && w->ends[s].longest > kMax - 93);
    tandem_peer_stats stats;
    tandem_peer_get_stats(sites[s].peer, &stats);
    CHECK(stats.packets_rejected == 0 && stats.updates_received > 200 * (kShared + 1));
    for (int i = 0; i < kShared; ++i) {
      tandem_state state;
      CHECK(tandem_body_state(sites[s].world, bodies[s][i], &state, NULL) == TANDEM_OK);
      CHECK(i < kHeld ? state.pose.position.x > 0.9 : fabs(state.pose.position.x) < 1e-6);
    }
  }
  for (int s = 0; s < 2; ++s) {
    destroy_site(&sites[s]);
    tandem_transport_destroy(transports[s]);
  }
  free(w);
}

/* An event comes once, with the time at which it was sent, beside what the peers share. */
static void channels_carry_events(void) {
  const tandem_link link = {.latency = 0.05, .loss = 0.3};
  const int64_t start = 1000000000, step = 16666667;
  tandem_network* network = tandem_network_create(&link, 3, start, NULL);
  tandem_channel* channels[2];
  site sites[2];
  for (int s = 0; s < 2; ++s) {
    channels[s] =
        tandem_channel_create(tandem_network_transport(network, (uint64_t)s + 1, NULL), NULL);
    CHECK(channels[s] != NULL);
    sites[s] = make_site(tandem_channel_transport(channels[s]), 0.1 * s);
  }
  int came = 0;
  for (int64_t k = 0; k < 240; ++k) {
    const int64_t now = start + k * step;
    CHECK(tandem_network_advance(network, now, NULL) == TANDEM_OK);
    for (int s = 0; s < 2; ++s) CHECK(tandem_channel_poll(channels[s], now, NULL) == TANDEM_OK);
    if (k == 10) CHECK(tandem_channel_send(channels[0], "door", "open", 4, 0, NULL) == TANDEM_OK);
    tandem_event event;
    if (tandem_channel_events(channels[1], &event, 1) == 1) {
      CHECK(strcmp(event.topic, "door") == 0 && event.topic_size == 4);
      CHECK(event.payload_size == 4 && memcmp(event.payload, "open", 4) == 0);
      CHECK(event.from == 1 && event.stamp_ns == start + 10 * step);
      ++came;
    }
    CHECK(tandem_channel_events(channels[0], NULL, 0) == 0);
    for (int s = 0; s < 2; ++s) step_site(&sites[s], now, now + step);
  }
  CHECK(came == 1);
  CHECK(fabs(place(&sites[0]) - place(&sites[1])) < 1e-3);
  CHECK(tandem_channel_send(channels[0], NULL, NULL, 0, 0, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_channel_send(channels[0], "t", NULL, 1, 0, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_channel_poll(channels[0], 0, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_channel_create(NULL, NULL) == NULL && tandem_channel_transport(NULL) == NULL);
  for (int s = 0; s < 2; ++s) {
    destroy_site(&sites[s]);
    tandem_channel_destroy(channels[s]);
  }
  tandem_network_destroy(network);
}

void peers_share(void) {
  two_peers_meet_in_the_middle();
  an_act_counts_at_both();
  a_hand_moves_and_leaves();
  a_transport_of_ones_own_carries_a_session();
  packets_are_no_longer_than_was_said();
  channels_carry_events();
}
