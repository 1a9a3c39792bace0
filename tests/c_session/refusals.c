/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
/*
 * What a program may get wrong of sessions: field, value and rule are named.
 */
#include <math.h>
#include <string.h>

#include "members.h"
#include "tandem/c/tandem.h"

/* Whether the text of a refusal has all of it. */
static int said(const tandem_error* error, const char* what, const char* rule, const char* value) {
  const int all = error->result == TANDEM_INVALID_ARGUMENT && strstr(error->text, what) != NULL &&
                  strstr(error->text, rule) != NULL && strstr(error->text, value) != NULL;
  if (!all) fprintf(stderr, "said: %s\n", error->text);
  return all;
}

static void wrong_options(void) {
  const room r = make_room(0.0);
  tandem_error error;
  tandem_session_def def;
  tandem_tcp_def tcp;
  tandem_session_def_init(&def);
  tandem_tcp_def_init(&tcp);
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "self", "not 0", "0"));
  tcp.self = 1;
  tcp.listen_port = 70000;
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "listen_port", "65535", "70000"));
  tcp.listen_port = 0; /* on all addresses, without a key */
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "listen_address", "of this machine", "0.0.0.0"));
  tcp.listen_address = "127.0.0.1";
  tcp.connect = "127.0.0.1:7777 nowhere";
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "nowhere", "HOST:PORT", ""));
  tcp.connect = NULL;
  tcp.credentials.trusted_count = 1;
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "trusted", "given", "null"));
  tcp.credentials.trusted_count = 0;
  const double rates[] = {0.0, -60.0, 1e5, NAN};
  for (size_t i = 0; i < sizeof rates / sizeof *rates; ++i) {
    def.rate = rates[i];
    CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
    CHECK(said(&error, "rate", "from 0.1 to 10000", ""));
  }
  tandem_session_def_init(&def);
  def.peer.influence = 2.0;
  CHECK(tandem_session_create_tcp(r.world, &tcp, &def, &error) == NULL);
  CHECK(said(&error, "baseline", "", "2"));
  CHECK(tandem_session_create_tcp(NULL, &tcp, &def, &error) == NULL);
  CHECK(tandem_session_create_tcp(r.world, NULL, &def, &error) == NULL);
  CHECK(said(&error, "tcp", "given", "null"));
  CHECK(tandem_session_create_tcp(r.world, &tcp, NULL, &error) == NULL);
  CHECK(tandem_session_create_udp(r.world, NULL, NULL, &error) == NULL);
  CHECK(tandem_session_create(r.world, NULL, &def, &error) == NULL);
  tandem_world_destroy(r.world);
}

static void half_a_spawner(void) {
  const tandem_link link = {.latency = 0.0};
  const room r = make_room(0.0);
  tandem_network* network = tandem_network_create(&link, 1, 1000000000, NULL);
  tandem_transport* transport = tandem_network_transport(network, 1, NULL);
  tandem_error error;
  tandem_session_def def;
  const tandem_pose here = {{0, 0, 0}, {0, 0, 0, 1}};
  tandem_session_def_init(&def);
  tandem_session* session = tandem_session_create(r.world, transport, &def, &error);
  CHECK(session != NULL);
  CHECK(tandem_session_spawn(session, "ball", &here, NULL, NULL, &error) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "make", "set", "empty"));
  CHECK(tandem_session_create(r.world, transport, &def, &error) == NULL);
  CHECK(said(&error, "world", "no other peer", "taken"));
  tandem_session_destroy(session);
  tandem_network_destroy(network);
  tandem_world_destroy(r.world);
}

typedef struct nested {
  tandem_session* session;
  tandem_result result;
} nested;

static void advances_again(void* user, int64_t now_ns) {
  nested* const n = user;
  n->result = tandem_session_advance(n->session, now_ns, NULL, NULL, NULL, NULL);
}

static void wrong_calls(void) {
  const tandem_link link = {.latency = 0.0};
  const room r = make_room(0.0);
  tandem_network* network = tandem_network_create(&link, 1, 1000000000, NULL);
  tandem_error error;
  tandem_session_def def;
  tandem_session_def_init(&def);
  tandem_session* session =
      tandem_session_create(r.world, tandem_network_transport(network, 1, NULL), &def, &error);
  const tandem_shared_id unknown = tandem_shared_id_of("nothing");
  tandem_body body;
  CHECK(tandem_session_share(session, NULL, r.body, 0, NULL, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_share(session, "", r.body, 0, NULL, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "name", "1 character", "empty"));
  CHECK(tandem_session_share(session, "cube", r.body, 0, NULL, &error) == TANDEM_OK);
  CHECK(tandem_session_share(session, "cube", r.body, 0, NULL, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "cube", "", ""));
  CHECK(tandem_session_share_all(session, "all", NULL, 1, 0, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_unshare(session, unknown, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_body(session, unknown, &body, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "id", "shared", "-"));
  tandem_grab_def grab;
  uint32_t hand = 0;
  tandem_grab_def_init(&grab);
  grab.body = unknown;
  CHECK(tandem_session_grab(session, &grab, &hand, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_send(session, "tandem.spawn", NULL, 0, 0, &error) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "topic", "not begin with", "tandem.spawn"));
  CHECK(tandem_session_send(session, "door", NULL, 4, 0, &error) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_session_advance(session, INT64_MAX, NULL, NULL, NULL, &error) ==
        TANDEM_INVALID_ARGUMENT);
  CHECK(said(&error, "now_ns", "from", "9223372036854775807"));
  tandem_progress progress;
  CHECK(tandem_session_advance(session, 0, NULL, NULL, &progress, NULL) == TANDEM_OK);
  CHECK(progress.status == TANDEM_STEP_INVALID && progress.steps == 0);
  nested inner = {session, TANDEM_OK};
  CHECK(tandem_session_advance(session, 1000000000, NULL, NULL, NULL, NULL) == TANDEM_OK);
  CHECK(tandem_session_advance(session, 1020000000, advances_again, &inner, &progress, NULL) ==
        TANDEM_OK);
  CHECK(progress.steps > 0 && inner.result == TANDEM_INVALID_ARGUMENT);
  tandem_session_destroy(session);
  tandem_network_destroy(network);
  tandem_world_destroy(r.world);
}

static void no_session_at_all(void) {
  tandem_session_stats stats;
  memset(&stats, 0xff, sizeof stats);
  tandem_session_get_stats(NULL, &stats);
  CHECK(stats.peer.bytes_sent == 0 && stats.events_lost == 0);
  tandem_session_get_stats(NULL, NULL);
  CHECK(tandem_session_now(NULL) == 0 && tandem_session_port(NULL) == 0);
  CHECK(tandem_session_self(NULL) == 0 && tandem_session_members(NULL, NULL, 3) == 0);
  CHECK(tandem_session_joined(NULL, NULL, 3) == 0 && tandem_session_left(NULL, NULL, 3) == 0);
  CHECK(tandem_session_events(NULL, NULL, 3) == 0);
  CHECK(tandem_session_advance(NULL, 1, NULL, NULL, NULL, NULL) == TANDEM_INVALID_ARGUMENT);
  CHECK(tandem_key_make(NULL, NULL) != TANDEM_OK && tandem_key_peer(NULL) == 0);
  tandem_session_def_init(NULL);
  tandem_tcp_def_init(NULL);
  tandem_udp_def_init(NULL);
  tandem_session_destroy(NULL);
}

void wrong_sessions_are_refused(void) {
  wrong_options();
  half_a_spawner();
  wrong_calls();
  no_session_at_all();
}
