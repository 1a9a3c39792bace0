/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * Sessions over sockets of this machine, in real time.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <threads.h>
#include <time.h>
#endif

#include "members.h"
#include "tandem/c/tandem.h"

enum { kMembers = 2 };

static void sleep_1_ms(void) {
#ifdef _WIN32
  Sleep(1);
#else
  thrd_sleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
#endif
}

typedef struct members {
  room rooms[kMembers];
  tandem_session* sessions[kMembers];
  int joined[kMembers]; /* how often the other one was seen to come */
} members;

/* Go on for so many seconds by the sessions' own clocks, or until both have seen the other. */
static void run(members* m, double seconds, int until_joined) {
  const int64_t begin = tandem_session_now(m->sessions[0]);
  while (tandem_session_now(m->sessions[0]) - begin < (int64_t)(seconds * 1e9)) {
    for (int i = 0; i < kMembers; ++i) {
      const int64_t now = tandem_session_now(m->sessions[i]);
      uint64_t other = 0;
      CHECK(tandem_session_advance(m->sessions[i], now, NULL, NULL, NULL, NULL) == TANDEM_OK);
      if (tandem_session_joined(m->sessions[i], &other, 1) == 1) {
        CHECK(other == (uint64_t)(2 - i));
        ++m->joined[i];
      }
    }
    if (until_joined && m->joined[0] > 0 && m->joined[1] > 0) return;
    sleep_1_ms();
  }
}

static void begin(members* m) {
  memset(m, 0, sizeof *m);
  for (int i = 0; i < kMembers; ++i) m->rooms[i] = make_room(0.0);
}

static void end(members* m) {
  for (int i = 0; i < kMembers; ++i) {
    tandem_session_destroy(m->sessions[i]);
    tandem_world_destroy(m->rooms[i].world);
  }
}

/* Both hold it where the one pulls it to; the spring is stiff and damped, so within 2 s it is
 * there. */
static void a_pulled_cube_is_where_the_hand_is(members* m) {
  tandem_grab_def grab;
  uint32_t hand = 0;
  for (int i = 0; i < kMembers; ++i) {
    CHECK(tandem_session_share(m->sessions[i], "cube", m->rooms[i].body, 0, NULL, NULL) ==
          TANDEM_OK);
  }
  run(m, 20.0, 1);
  CHECK(m->joined[0] == 1 && m->joined[1] == 1);
  tandem_grab_def_init(&grab);
  grab.body = tandem_shared_id_of("cube");
  grab.anchor = (tandem_vec3){1.0, 0.0, 0.0};
  CHECK(tandem_session_grab(m->sessions[0], &grab, &hand, NULL) == TANDEM_OK);
  run(m, 3.0, 0);
  CHECK(fabs(place(&m->rooms[0]) - 1.0) < 0.01);
  CHECK(fabs(place(&m->rooms[1]) - 1.0) < 0.01);

  tandem_member other;
  CHECK(tandem_session_members(m->sessions[1], &other, 1) == 1);
  CHECK(other.id == 1 && other.connected && other.reason[0] == 0);
  CHECK(other.packets_in > 60 && other.bytes_in > 60 * 93);
  tandem_session_stats stats;
  tandem_session_get_stats(m->sessions[1], &stats);
  CHECK(stats.peer.updates_received > 60 && stats.peer.packets_rejected == 0);
}

/* A destroyed session announces that it leaves: the other sees it long before the idle timeout. */
static void who_goes_says_goodbye(members* m) {
  tandem_session_destroy(m->sessions[0]);
  m->sessions[0] = NULL;
  const int64_t begin = tandem_session_now(m->sessions[1]);
  int64_t now = begin;
  uint64_t gone = 0;
  while (gone == 0 && now - begin < 3000000000) {
    now = tandem_session_now(m->sessions[1]);
    CHECK(tandem_session_advance(m->sessions[1], now, NULL, NULL, NULL, NULL) == TANDEM_OK);
    CHECK(tandem_session_left(m->sessions[1], &gone, 1) <= 1);
  }
  CHECK(gone == 1);
  tandem_member other;
  CHECK(tandem_session_members(m->sessions[1], &other, 1) == 1 && !other.connected);
}

static void over_tcp(void) {
  tandem_error error;
  tandem_session_def def;
  tandem_tcp_def tcp;
  char there[32];
  members m;
  begin(&m);
  tandem_session_def_init(&def);
  tandem_tcp_def_init(&tcp);
  tcp.self = 1;
  tcp.listen_port = 0;
  tcp.listen_address = "127.0.0.1";
  m.sessions[0] = tandem_session_create_tcp(m.rooms[0].world, &tcp, &def, &error);
  CHECK(m.sessions[0] != NULL);
  CHECK(tandem_session_port(m.sessions[0]) > 0 && tandem_session_self(m.sessions[0]) == 1);
  snprintf(there, sizeof there, " 127.0.0.1:%d ", (int)tandem_session_port(m.sessions[0]));
  tcp.self = 2;
  tcp.listen_port = -1;
  tcp.connect = there;
  m.sessions[1] = tandem_session_create_tcp(m.rooms[1].world, &tcp, &def, &error);
  CHECK(m.sessions[1] != NULL && tandem_session_port(m.sessions[1]) == 0);
  a_pulled_cube_is_where_the_hand_is(&m);
  who_goes_says_goodbye(&m);
  end(&m);
}

static tandem_session* over_udp(tandem_world* world, uint64_t self, const char* there,
                                const tandem_credentials* credentials, tandem_error* error) {
  tandem_session_def def;
  tandem_udp_def udp;
  tandem_session_def_init(&def);
  tandem_udp_def_init(&udp);
  udp.self = self;
  udp.listen_address = "127.0.0.1";
  udp.connect = there;
  udp.credentials = *credentials;
  return tandem_session_create_udp(world, &udp, &def, error);
}

/* With keys of their own, which each is told of the other; a third one has the session's alone. */
static void over_udp_with_keys(void) {
  tandem_key session_key, identities[kMembers], stranger;
  tandem_trusted trusted[kMembers];
  tandem_credentials credentials[kMembers];
  tandem_error error;
  char there[32];
  members m;
  begin(&m);
  CHECK(tandem_key_make(&session_key, &error) == TANDEM_OK);
  CHECK(tandem_key_make(&stranger, NULL) == TANDEM_OK);
  CHECK(memcmp(&session_key, &stranger, sizeof stranger) != 0);
  for (int i = 0; i < kMembers; ++i) {
    CHECK(tandem_key_make(&identities[i], NULL) == TANDEM_OK);
    trusted[1 - i].peer = (uint64_t)(i + 1);
    CHECK(tandem_key_public(&identities[i], &trusted[1 - i].public_key, NULL) == TANDEM_OK);
    CHECK(tandem_key_peer(&trusted[1 - i].public_key) >> 63 == 1);
  }
  for (int i = 0; i < kMembers; ++i) {
    credentials[i] = (tandem_credentials){.session_key = &session_key,
                                          .identity = &identities[i],
                                          .trusted = &trusted[i],
                                          .trusted_count = 1};
  }
  m.sessions[0] = over_udp(m.rooms[0].world, 1, NULL, &credentials[0], &error);
  CHECK(m.sessions[0] != NULL);
  snprintf(there, sizeof there, "127.0.0.1:%d", (int)tandem_session_port(m.sessions[0]));
  m.sessions[1] = over_udp(m.rooms[1].world, 2, there, &credentials[1], &error);
  CHECK(m.sessions[1] != NULL && tandem_session_port(m.sessions[1]) > 0);

  const room third = make_room(0.0);
  const tandem_credentials false_one = {.session_key = &session_key, .identity = &stranger};
  tandem_session* intruder = over_udp(third.world, 2, there, &false_one, &error);
  CHECK(intruder != NULL);
  a_pulled_cube_is_where_the_hand_is(&m);
  tandem_member seen;
  if (tandem_session_members(intruder, &seen, 1) == 1) CHECK(!seen.connected);
  tandem_session_destroy(intruder);
  tandem_world_destroy(third.world);
  who_goes_says_goodbye(&m);
  end(&m);
}

/* Errors of a build without libsodium about keys and UDP. */
static void says_that_there_is_no_udp(void) {
  tandem_error error;
  tandem_key key = {{0}};
  const tandem_credentials none = {.session_key = NULL};
  const room r = make_room(0.0);
  CHECK(tandem_key_make(&key, &error) == TANDEM_FAILED && strstr(error.text, "libsodium") != NULL);
  CHECK(tandem_key_peer(&key) == 0);
  CHECK(over_udp(r.world, 1, NULL, &none, &error) == NULL);
  CHECK(error.result == TANDEM_FAILED && strstr(error.text, "libsodium") != NULL);
  tandem_world_destroy(r.world);
}

void sessions_over_sockets(void) {
  tandem_key key;
  over_tcp();
  if (tandem_key_make(&key, NULL) == TANDEM_OK) {
    over_udp_with_keys();
  } else {
    says_that_there_is_no_udp();
  }
}
