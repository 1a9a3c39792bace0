/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Sessions from C, in virtual time; sockets.c has those in real time.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "members.h"
#include "tandem/c/tandem.h"

int failures = 0;

enum { kMembers = 2, kBalls = 4 };
static const int64_t kStart = 1000000000, kStepNs = 16666667;

/* A member whose world has what it shares and what was spawned. */
typedef struct member {
  room room;
  tandem_session* session;
  tandem_body balls[kBalls];
  int made, removed;
  int came; /* events */
} member;

typedef struct scene {
  tandem_network* network;
  member members[kMembers];
  int64_t step;
} scene;

static int32_t make_ball(void* user, const char* what, size_t size, tandem_body* body) {
  member* const m = user;
  if (strlen(what) != size || strcmp(what, "ball") != 0 || m->made == kBalls) return 0;
  *body = add_body(m->room.world, TANDEM_DYNAMIC, 0.0, 0.0);
  m->balls[m->made++] = *body;
  return 1;
}

static void remove_ball(void* user, tandem_body body) {
  member* const m = user;
  CHECK(tandem_body_remove(m->room.world, body, NULL) == TANDEM_OK);
  ++m->removed;
}

static void begin(scene* s, double apart) {
  const tandem_link link = {.latency = 0.03};
  memset(s, 0, sizeof *s);
  s->network = tandem_network_create(&link, 1, kStart, NULL);
  for (int i = 0; i < kMembers; ++i) {
    member* const m = &s->members[i];
    tandem_session_def def;
    m->room = make_room(apart * i);
    tandem_session_def_init(&def);
    def.peer.authority_ramp = 0.0;
    def.make = make_ball;
    def.remove = remove_ball;
    def.user = m;
    m->session = tandem_session_create(
        m->room.world, tandem_network_transport(s->network, (uint64_t)(i + 1), NULL), &def, NULL);
    CHECK(m->session != NULL);
  }
}

static void end(scene* s) {
  for (int i = 0; i < kMembers; ++i) {
    tandem_session_destroy(s->members[i].session);
    tandem_world_destroy(s->members[i].room.world);
  }
  tandem_network_destroy(s->network);
}

static void heard(void* user, int64_t now_ns) {
  member* const m = user;
  tandem_event event;
  CHECK(now_ns > 0);
  if (tandem_session_events(m->session, &event, 1) == 0) return;
  CHECK(event.from == 1 && event.topic_size == 4 && strcmp(event.topic, "door") == 0);
  CHECK(event.payload_size == 4 && memcmp(event.payload, "open", 4) == 0);
  ++m->came;
}

/* @return the steps of the last member */
static int go_on(scene* s, int steps) {
  int made = 0;
  for (int k = 0; k < steps; ++k) {
    ++s->step;
    CHECK(tandem_network_advance(s->network, kStart + s->step * kStepNs, NULL) == TANDEM_OK);
    for (int i = 0; i < kMembers; ++i) {
      member* const m = &s->members[i];
      tandem_progress progress;
      if (m->session == NULL) continue;
      /* The network's, as nobody gave another. */
      CHECK(tandem_session_now(m->session) == kStart + s->step * kStepNs);
      CHECK(tandem_session_advance(m->session, tandem_session_now(m->session), heard, m, &progress,
                                   NULL) == TANDEM_OK);
      CHECK(progress.status == TANDEM_STEP_OK && !progress.stepped_elsewhere);
      if (i == kMembers - 1) made += progress.steps;
    }
  }
  return made;
}

/* Equal shares meet in the middle; a hand takes it along; who lets go holds nothing. */
static void two_members_agree(void) {
  scene s;
  tandem_shared_id id = {0, 0};
  begin(&s, 0.1);
  for (int i = 0; i < kMembers; ++i) {
    CHECK(tandem_session_share(s.members[i].session, "cube", s.members[i].room.body, 0, &id,
                               NULL) == TANDEM_OK);
  }
  const tandem_shared_id named = tandem_shared_id_of("cube");
  CHECK(id.high == named.high && id.low == named.low);
  CHECK(abs(go_on(&s, 240) - 240) <= 1);
  CHECK(fabs(place(&s.members[0].room) - place(&s.members[1].room)) < 1e-4);
  CHECK(fabs(place(&s.members[0].room) - 0.05) < 0.005);
  tandem_body here = TANDEM_NO_BODY;
  CHECK(tandem_session_body(s.members[1].session, id, &here, NULL) == TANDEM_OK);
  CHECK(here.index == s.members[1].room.body.index);

  tandem_grab_def grab;
  uint32_t hand = 0;
  int32_t holds = 0;
  tandem_grab_def_init(&grab);
  grab.body = id;
  CHECK(tandem_session_grab(s.members[0].session, &grab, &hand, NULL) == TANDEM_OK);
  CHECK(tandem_session_move(s.members[0].session, hand, (tandem_vec3){1, 0, 0}, &holds, NULL) ==
        TANDEM_OK);
  CHECK(holds);
  go_on(&s, 240);
  CHECK(fabs(place(&s.members[1].room) - 1.0) < 0.01);
  CHECK(tandem_session_release(s.members[0].session, hand, NULL) == TANDEM_OK);
  CHECK(tandem_session_release(s.members[0].session, hand, NULL) == TANDEM_OK);
  CHECK(tandem_session_move(s.members[0].session, hand, (tandem_vec3){0, 0, 0}, &holds, NULL) ==
        TANDEM_OK);
  CHECK(!holds);
  end(&s);
}

/* A body spawned by one member exists, is kicked, and is removed at both. */
static void what_one_spawns_is_everybodys(void) {
  scene s;
  const tandem_pose there = {{2.0, 0, 0}, {0, 0, 0, 1}};
  tandem_shared_id id = {0, 0};
  tandem_act_def act;
  begin(&s, 0.0);
  go_on(&s, 30);
  member* const one = &s.members[0];
  member* const two = &s.members[1];
  CHECK(tandem_session_spawn(one->session, "cat", &there, NULL, NULL, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_spawn(one->session, "ball", &there, NULL, &id, NULL) == TANDEM_OK);
  go_on(&s, 30);
  CHECK(one->made == 1 && two->made == 1);
  CHECK(fabs(place_of(two->room.world, two->balls[0]) - 2.0) < 1e-9);
  tandem_act_def_init(&act);
  act.body = id;
  act.impulse.x = 1.0;
  CHECK(tandem_session_act(two->session, &act, NULL) == TANDEM_OK);
  go_on(&s, 60); /* 1 kg at 1 m/s for 1 s */
  CHECK(fabs(place_of(one->room.world, one->balls[0]) - 3.0) < 0.02);
  CHECK(fabs(place_of(two->room.world, two->balls[0]) - 3.0) < 0.02);
  CHECK(tandem_session_despawn(two->session, id, NULL) == TANDEM_OK);
  go_on(&s, 30);
  CHECK(one->removed == 1 && two->removed == 1);
  CHECK(!tandem_body_exists(one->room.world, one->balls[0]));
  CHECK(tandem_session_despawn(one->session, id, NULL) == TANDEM_INVALID_ARGUMENT);
  end(&s);
}

/* Each is told once, of the advance in which it happened. */
static void who_comes_and_goes_is_told_once(void) {
  scene s;
  uint64_t peer = 0;
  int joined = 0, left = 0;
  begin(&s, 0.0);
  for (int k = 0; k < 60; ++k) {
    go_on(&s, 1);
    joined += (int)tandem_session_joined(s.members[1].session, &peer, 1);
  }
  CHECK(joined == 1 && peer == 1);
  tandem_session_destroy(s.members[0].session);
  s.members[0].session = NULL;
  tandem_member other;
  CHECK(tandem_session_members(s.members[1].session, &other, 1) == 1 && other.id == 1);
  for (int k = 0; k < 60; ++k) {
    go_on(&s, 1);
    left += (int)tandem_session_left(s.members[1].session, &peer, 1);
  }
  /* The network's wires stay where they are, whoever is at their ends. */
  CHECK(left == 0 && other.connected);
  end(&s);
}

/* An event comes once, and is there after the advance in which it came. */
static void an_event_comes_once(void) {
  scene s;
  tandem_event event;
  begin(&s, 0.0);
  go_on(&s, 30);
  CHECK(tandem_session_send(s.members[0].session, "door", "open", 4, 0, NULL) == TANDEM_OK);
  int after = 0;
  for (int k = 0; k < 60; ++k) {
    go_on(&s, 1);
    if (tandem_session_events(s.members[1].session, &event, 1) == 1) {
      CHECK(memcmp(event.payload, "open", 4) == 0 && event.stamp_ns > kStart);
      ++after;
    }
  }
  CHECK(s.members[1].came == 1 && after == 1 && s.members[0].came == 0);
  tandem_session_stats stats;
  tandem_session_get_stats(s.members[1].session, &stats);
  CHECK(stats.events_lost == 0 && stats.events_rejected == 0 && stats.spawns_refused == 0);
  end(&s);
}

/* All of them, or none where one of them cannot be. */
static void many_are_shared_as_one_thing(void) {
  scene s;
  tandem_body here;
  begin(&s, 0.0);
  member* const m = &s.members[0];
  const tandem_body bodies[2] = {m->room.body, add_body(m->room.world, TANDEM_DYNAMIC, 1.0, 0.0)};
  const tandem_body wrong[2] = {bodies[0], add_body(m->room.world, TANDEM_STATIC, 2.0, 0.0)};
  CHECK(tandem_session_share_all(m->session, "pair", wrong, 2, 0, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_body(m->session, tandem_shared_id_of("pair/0"), &here, NULL) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_share_all(m->session, "pair", bodies, 2, 0, NULL) == TANDEM_OK);
  CHECK(tandem_session_body(m->session, tandem_shared_id_of("pair/1"), &here, NULL) == TANDEM_OK);
  CHECK(here.index == bodies[1].index);
  CHECK(tandem_session_unshare(m->session, tandem_shared_id_of("pair/1"), NULL) == TANDEM_OK);
  end(&s);
}

static int64_t seven_seconds(void* user) { return *(const int64_t*)user; }

/* Time stands still where the clock does; half a step makes none. */
static void goes_by_the_clock_it_was_given(void) {
  const tandem_link link = {.latency = 0.0};
  const room r = make_room(0.0);
  tandem_network* network = tandem_network_create(&link, 1, kStart, NULL);
  int64_t time = 7000000000;
  tandem_session_def def;
  tandem_progress progress;
  tandem_session_def_init(&def);
  def.rate = 100.0;
  def.clock = seven_seconds;
  def.user = &time;
  tandem_session* session =
      tandem_session_create(r.world, tandem_network_transport(network, 1, NULL), &def, NULL);
  CHECK(tandem_session_now(session) == 7000000000);
  CHECK(tandem_session_advance(session, time, NULL, NULL, &progress, NULL) == TANDEM_OK);
  CHECK(progress.steps == 0);
  CHECK(tandem_session_advance(session, time + 35000000, NULL, NULL, &progress, NULL) == TANDEM_OK);
  CHECK(progress.steps == 3 && progress.lag_ns == 5000000); /* of 10 ms */
  CHECK(tandem_world_step(r.world, 0.01, NULL, NULL) == TANDEM_OK);
  CHECK(tandem_session_advance(session, time + 40000000, NULL, NULL, &progress, NULL) == TANDEM_OK);
  CHECK(progress.steps == 1 && progress.stepped_elsewhere);
  tandem_session_destroy(session);
  tandem_network_destroy(network);
  tandem_world_destroy(r.world);
}

int main(void) {
  two_members_agree();
  what_one_spawns_is_everybodys();
  who_comes_and_goes_is_told_once();
  an_event_comes_once();
  many_are_shared_as_one_thing();
  goes_by_the_clock_it_was_given();
  wrong_sessions_are_refused();
  sessions_over_sockets();
  if (failures == 0) printf("c_session: all claims hold\n");
  return failures == 0 ? 0 : 1;
}
