// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who has a place in a session over TCP that is full. In virtual time, without sockets.
#include "peer_table.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "support/catch.h"

namespace peer_table_test {
namespace {

using namespace tandem::net;
using std::chrono::seconds;

/// A peer in a session of three others.
class Here {
 public:
  Here() : table_(options()) {}

  /// As id `peer`, by a key of that number. @return the link that gives way, 0: none; or nothing
  std::optional<std::uint64_t> join(PeerId peer, std::uint8_t key, bool bound = false) {
    Member member{.bound = bound};
    member.key.fill(key);
    const Hello hello{.peer = peer, .incarnation = 1, .max_message_bytes = 1024};
    refusal = table_.refusal(hello, member, now).value_or("");
    ++links;
    const auto result = table_.attach(links, hello, member, {}, links, now);
    CHECK(result.attached == refusal.empty());
    if (!result.attached) return {};
    return result.replaced_link;
  }
  void leave(PeerId peer) { table_.detach(table_.link_of(peer), peer, "connection lost"); }
  /// All who are here are heard each second.
  void wait(int duration) {
    for (int i = 0; i < duration; ++i) {
      now += seconds(1);
      for (const auto& each : table_.peers()) table_.charge(table_.link_of(each.id), each.id, now);
    }
  }
  bool has(PeerId peer) const { return table_.link_of(peer) != 0; }
  std::uint64_t link_of(PeerId peer) const { return table_.link_of(peer); }

  SteadyTime now{seconds(1000)};
  std::uint64_t links = 0;
  std::string refusal;

 private:
  static TcpOptions options() {
    TcpOptions out;
    out.self = 1;
    out.max_peers = 3;
    return out;
  }

  PeerTable table_;
};

}  // namespace

TEST_CASE("tcp: a returning peer has a place even if all were taken meanwhile", "[net][fault]") {
  Here here;
  REQUIRE(here.join(2, 2));
  REQUIRE(here.join(3, 3));
  here.wait(11);
  here.leave(2);
  REQUIRE(here.join(100, 9));
  REQUIRE(here.join(101, 9));
  here.wait(60);
  // A newcomer is told why he is not let in, as is who has the id and not the key.
  CHECK_FALSE(here.join(4, 4));
  CHECK(here.refusal == "session full: 3 peers");
  CHECK_FALSE(here.join(2, 9));
  // The last one who came gives way.
  const std::uint64_t last = here.link_of(101);
  CHECK(here.join(2, 2) == last);
  CHECK((here.has(2) && here.has(3) && here.has(100)));
  CHECK_FALSE(here.has(101));
  // However long he had been here.
  CHECK_FALSE(here.join(101, 9));
  CHECK(here.has(2));
}

TEST_CASE("tcp: a brief member keeps no place, and a bound one gives way to no other",
          "[net][fault]") {
  const bool bound = GENERATE(false, true);
  Here here;
  REQUIRE(here.join(2, 2));
  here.wait(bound ? 11 : 5);
  here.leave(2);
  for (PeerId id = 100; id < 103; ++id)
    REQUIRE(here.join(id, static_cast<std::uint8_t>(id), bound));
  CHECK_FALSE(here.join(2, 2));
  here.leave(101);
  CHECK(here.join(2, 2) == 0U);
}

TEST_CASE("tcp: the elder of two returning members gets the place and keeps it", "[net][fault]") {
  Here here;
  for (PeerId id = 2; id < 5; ++id) REQUIRE(here.join(id, static_cast<std::uint8_t>(id)));
  here.wait(11);
  here.leave(2);
  REQUIRE(here.join(5, 5));
  here.wait(11);
  // 3 reconnects, which makes it no younger.
  here.leave(3);
  REQUIRE(here.join(3, 3) == 0U);
  const std::uint64_t youngest = here.link_of(5);
  CHECK(here.join(2, 2) == youngest);
  for (int i = 0; i < 5; ++i) {
    here.wait(11);
    CHECK_FALSE(here.join(5, 5));
    CHECK((here.has(2) && here.has(3) && here.has(4)));
  }
}

}  // namespace peer_table_test
