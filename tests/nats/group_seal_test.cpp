// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "group_seal.h"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "net/protocol_support.h"
#include "support/catch.h"

namespace tandem::nats::group_seal_test {
namespace {

using consensus::PeerId;
using protocol::Bytes;
using protocol::seeded;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kStart = 1'700'000'000 * kSecond;

net::Credentials member(std::uint64_t key) {
  net::Credentials out;
  out.session_key = protocol::secret(key);
  return out;
}

/// One process of a member. Its clock is the others' but for `ahead`, ns.
struct Process {
  explicit Process(PeerId peer, std::uint64_t run, std::int64_t clock = 0)
      : incarnation(run), ahead(clock), sealer(peer, run, seeded(run)) {}

  Bytes say(const net::Credentials& own, std::int64_t now, const char* what = "here I am") {
    Bytes out;
    sealer.seal(protocol::text(what), own.session_key, now + ahead, out);
    return out;
  }

  std::uint64_t incarnation;
  std::int64_t ahead;
  GroupSealer sealer;
};

/// A listener that hears them all. Nobody is connected at first.
struct Listener {
  explicit Listener(std::int64_t from = kStart) : opener(from), now(from) {}

  GroupOpener::Heard hear(const Bytes& message, const net::Credentials& own) {
    const auto opened = opener.open(message, own, now, [this](PeerId peer) {
      const auto at = connected.find(peer);
      return at != connected.end() ? std::optional(at->second) : std::nullopt;
    });
    return opened.heard;
  }

  GroupOpener opener;
  std::int64_t now;
  std::map<PeerId, std::uint64_t> connected;
};

using enum GroupOpener::Heard;

TEST_CASE("group seal: members read it once, nobody else reads, changes or repeats it",
          "[nats][fault]") {
  const net::Credentials own = member(1);
  Process sender(5, 2);
  Listener listener;
  const Bytes plain = protocol::text("here I am");
  const Bytes first = sender.say(own, kStart + 1);
  const Bytes second = sender.say(own, kStart + 1);
  CHECK(first.size() == plain.size() + kGroupOverhead);
  CHECK(std::search(first.begin(), first.end(), plain.begin(), plain.end()) == first.end());

  for (std::size_t i = 0; i < first.size(); ++i) {
    Bytes changed = first;
    changed[i] ^= std::byte{1};
    CHECK(listener.hear(changed, own) == Refused);
    CHECK(listener.hear(Bytes(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(i)),
                        own) == Refused);
  }
  CHECK(listener.hear(first, member(2)) == Refused);
  const auto opened = listener.opener.open(first, own, kStart, [](PeerId) { return std::nullopt; });
  REQUIRE(opened.heard == Now);
  CHECK(opened.sender == 5);
  CHECK(Bytes(opened.plain.begin(), opened.plain.end()) == plain);
  CHECK(listener.hear(first, own) == Refused);
  CHECK(listener.hear(second, own) == Now);
  CHECK(listener.hear(first, own) == Refused);
}

TEST_CASE("group seal: two processes of one peer have keys of their own", "[nats]") {
  const net::Credentials own = member(1);
  Process before(5, 2);
  Process after(5, 3);
  const Bytes first = before.say(own, kStart + 1);
  const Bytes second = after.say(own, kStart + 1);
  CHECK(Bytes(first.begin() + kGroupHeader, first.end()) !=
        Bytes(second.begin() + kGroupHeader, second.end()));
  CHECK(after.sealer.has_sealed(second));
  CHECK_FALSE(after.sealer.has_sealed(first));
}

TEST_CASE("group seal: of two lives of a peer nothing opens twice, in any order", "[nats][fault]") {
  const net::Credentials own = member(1);
  Process before(5, 2);
  Process after(5, 3);
  const bool is_connected = GENERATE(false, true);
  Listener listener;
  std::vector<Bytes> said;
  const auto live = [&](Process& process) {
    if (is_connected) listener.connected[5] = process.incarnation;
    for (int i = 0; i < 10; ++i) {
      listener.now += kSecond / 10;
      said.push_back(process.say(own, listener.now));
      REQUIRE(listener.hear(said.back(), own) == Now);
    }
  };
  live(before);
  live(after);
  for (int round = 0; round < 3; ++round) {
    for (const Bytes& each : said) CHECK(listener.hear(each, own) != Now);
    for (std::size_t i = 0; i < 10; ++i) {  // one life and the other in turn
      CHECK(listener.hear(said[i], own) != Now);
      CHECK(listener.hear(said[10 + i], own) != Now);
    }
    listener.connected.clear();
    listener.now += kSecond;
  }
}

TEST_CASE("group seal: a new listener opens no earlier messages", "[nats][fault]") {
  const net::Credentials own = member(1);
  Process sender(5, 2);
  std::vector<Bytes> said;
  for (int i = 0; i < 600; ++i) said.push_back(sender.say(own, kStart + i * kSecond / 10));
  Listener listener(kStart + 60 * kSecond);
  for (const Bytes& each : said) CHECK(listener.hear(each, own) != Now);
  CHECK(listener.hear(sender.say(own, listener.now + 1), own) == Now);
}

TEST_CASE("group seal: a member with a wrong clock is heard once connected, each time once",
          "[nats][fault]") {
  const net::Credentials own = member(1);
  const std::int64_t wrong = GENERATE(-3600, -10, 10, 86400) * kSecond;
  Process sender(5, 2, wrong);
  Listener listener;
  const Bytes early = sender.say(own, kStart);
  CHECK(listener.hear(early, own) == Elsewhen);
  CHECK(listener.hear(early, own) == Elsewhen);
  listener.connected[5] = sender.incarnation;
  std::vector<Bytes> said;
  const auto speak = [&] {
    listener.now += kSecond;
    said.push_back(sender.say(own, listener.now));
    CHECK(listener.hear(said.back(), own) == Now);
  };
  speak();
  listener.connected.clear();
  speak();
  // The clock is right in the next life, and what was said in the one before comes again whenever.
  Process after(5, 3);
  listener.connected[5] = after.incarnation;
  listener.now += kSecond;
  CHECK(listener.hear(after.say(own, listener.now), own) == Now);
  listener.connected.clear();
  for (const std::int64_t later : {std::int64_t{0}, wrong}) {
    if (later < 0) continue;
    listener.now += later;
    if (later > 0) CHECK(listener.hear(after.say(own, listener.now), own) == Now);
    for (const Bytes& each : said) CHECK(listener.hear(each, own) != Now);
  }
}

TEST_CASE("group seal: a former session key makes nothing believed", "[nats][fault]") {
  net::Credentials own = member(1);
  const net::Credentials before = own;
  Process old(5, 2);
  Process fresh(6, 3);
  Listener listener;
  CHECK(listener.hear(old.say(before, kStart + 1), own) == Now);
  const Bytes kept = old.say(before, kStart + 2);
  own.former = {own.session_key};
  own.session_key = protocol::secret(9);
  own.group = 1;
  // In the name of anybody: it says that he may be there, whom a handshake then finds, or not.
  Process anybody(6, 4);
  for (const Bytes& each : {old.say(before, kStart + 3), anybody.say(before, kStart + 3)}) {
    const auto opened =
        listener.opener.open(each, own, kStart, [](PeerId) { return std::nullopt; });
    CHECK(opened.heard == Elsewhen);
    CHECK(opened.plain.empty());
    CHECK(opened.key == 1);
  }
  CHECK(listener.hear(fresh.say(own, kStart + 3), own) == Now);
  CHECK(listener.hear(kept, own) == Elsewhen);
  CHECK(listener.hear(old.say(own, kStart + 4), own) == Now);
  CHECK(listener.hear(kept, own) == Refused);
  own.former.clear();
  CHECK(listener.hear(anybody.say(before, kStart + 5), own) == Refused);
}

TEST_CASE("group seal: memory for senders is bounded, forgotten messages do not open again",
          "[nats][fault]") {
  const net::Credentials own = member(1);
  Listener listener;
  std::vector<Bytes> said;
  for (std::uint64_t id = 1; id <= GroupOpener::kMaxSenders + 100; ++id) {
    Process sender(id, id);
    listener.now += 1'000;
    said.push_back(sender.say(own, listener.now));
    CHECK(listener.hear(said.back(), own) == Now);
  }
  CHECK(listener.opener.senders() == GroupOpener::kMaxSenders);
  for (const Bytes& each : said) REQUIRE(listener.hear(each, own) != Now);
}

TEST_CASE("group seal: records kept on the server open for every reader", "[nats]") {
  const net::Credentials own = member(1);
  Process sender(5, 2);
  const Bytes kept = sender.say(own, 1);
  for (int i = 0; i < 2; ++i) {
    const auto opened = open_group_record(kept, own.session_key);
    REQUIRE(opened.has_value());
    CHECK(opened->sender == 5);
    CHECK(opened->plain == protocol::text("here I am"));
  }
  CHECK_FALSE(open_group_record(kept, protocol::secret(2)).has_value());
}

}  // namespace
}  // namespace tandem::nats::group_seal_test
