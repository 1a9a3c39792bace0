// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include "session_impl.h"
#include "sharing.h"
#include "tandem/pbd/validate.h"

using namespace tandem;
using namespace tandem::c;

namespace {

size_t copied_ids(const std::vector<PeerId>& from, uint64_t* to, size_t capacity) {
  if (to != nullptr) std::copy_n(from.begin(), std::min(from.size(), capacity), to);
  return from.size();
}

tandem_member member_of(const consensus::PeerStatus& peer) {
  tandem_member member{.id = peer.id,
                       .connected = peer.connected ? 1 : 0,
                       .reason = {},
                       .round_trip = peer.round_trip < 0 ? -1.0 : net::seconds(peer.round_trip),
                       .kbit_per_s = peer.kbit_per_s,
                       .packets_in = peer.packets_in,
                       .packets_out = peer.packets_out,
                       .bytes_in = peer.bytes_in,
                       .bytes_out = peer.bytes_out};
  std::copy_n(peer.reason.data(), whole_letters(peer.reason, sizeof member.reason - 1),
              member.reason);
  return member;
}

}  // namespace

size_t tandem_session_joined(const tandem_session* session, uint64_t* peers, size_t capacity) {
  return session != nullptr ? copied_ids(session->joined, peers, capacity) : 0;
}

size_t tandem_session_left(const tandem_session* session, uint64_t* peers, size_t capacity) {
  return session != nullptr ? copied_ids(session->left, peers, capacity) : 0;
}

size_t tandem_session_members(tandem_session* session, tandem_member* members, size_t capacity) {
  size_t count = 0;
  guarded(nullptr, [&] {
    const auto peers = required(session, "session").session->transport().peers();
    for (size_t i = 0; i < peers.size() && i < capacity && members != nullptr; ++i) {
      members[i] = member_of(peers[i]);
    }
    count = peers.size();
  });
  return count;
}

tandem_result tandem_session_send(tandem_session* session, const char* topic, const void* payload,
                                  size_t size, uint64_t to, tandem_error* error) {
  return guarded(error, [&] {
    tandem_session& s = required(session, "session");
    const std::string_view name = &required(topic, "topic");
    if (name.starts_with("tandem.")) {
      pbd::detail::refuse("topic", "one that does not begin with \"tandem.\"", name);
    }
    const auto* const bytes = static_cast<const std::byte*>(payload);
    if (size > 0) required(bytes, "payload");
    s.session->events().send(name, {bytes, size}, to);
  });
}

size_t tandem_session_events(const tandem_session* session, tandem_event* events, size_t capacity) {
  if (session == nullptr) return 0;
  for (size_t i = 0; i < session->events.size() && i < capacity && events != nullptr; ++i) {
    events[i] = to_c(session->events[i]);
  }
  return session->events.size();
}

void tandem_session_get_stats(const tandem_session* session, tandem_session_stats* stats) {
  if (stats == nullptr) return;
  *stats = {};
  if (session == nullptr) return;
  Session& s = *session->session;
  *stats = {.peer = to_c(s.peer().stats()),
            .spawns_refused = s.spawns_refused(),
            .events_lost = s.events().lost(),
            .events_rejected = s.events().rejected()};
}
