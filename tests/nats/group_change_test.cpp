// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Members of an organiser, whose session key changes, on a real server.
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "cell_wire.h"
#include "group_seal.h"
#include "hub_impl.h"
#include "nats/peers.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"

namespace tandem::nats::group_change_test {
namespace {

using namespace testing;

struct Organised {
  net::Key secret = net::make_key();
  std::map<PeerId, net::Key> members;

  NatsOptions options(std::uint16_t port, PeerId self, std::uint8_t key = 7) {
    NatsOptions out = options_of(port, self);
    const net::Key identity = members.emplace(self, net::make_key()).first->second;
    out.member.identity = identity;
    out.member.session_key = session_key(key);
    out.member.organiser = net::organiser_public_key(secret);
    out.member.certificate = net::sign(net::Certificate{.member = net::public_key(identity),
                                                        .peer = self,
                                                        .role = net::Role::Share,
                                                        .expires = 4'000'000'000},
                                       secret);
    return out;
  }
  std::vector<std::byte> change(std::uint8_t key, PeerId revoked) {
    return net::sign(net::GroupChange{.number = 1,
                                      .session_key = session_key(key),
                                      .revoked = {net::public_key(members.at(revoked))}},
                     secret);
  }
};

TEST_CASE(
    "nats: a revoked member is not heard under any name, and one that missed the change comes back",
    "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  Organised session;
  NatsTransport a(session.options(server.port(), 1));
  NatsTransport b(session.options(server.port(), 2));
  NatsTransport lost(session.options(server.port(), 3));
  REQUIRE(eventually([&] { return linked(a, b) && linked(a, lost) && linked(b, lost); }));
  REQUIRE(a.change_group(session.change(8, 3)));
  REQUIRE(eventually([&] { return b.group() == 1; }));
  // Neither the process that goes on nor what it says as somebody else.
  CHECK(eventually([&] { return a.status().contacts == 1 && b.status().contacts == 1; }));
  NatsHub own_hub(HubOptions{.servers = {{"127.0.0.1", server.port()}}});
  REQUIRE(eventually([&] { return own_hub.status().connected; }));
  const NatsOptions options = options_of(server.port(), 9);
  const Subjects subjects(options.prefix, options.member.scene_hash, options.cells);
  GroupSealer ghost(9, 1, net::crypto::system_random());
  const std::uint64_t before = a.status().refused;
  std::size_t most = 0;
  CHECK(eventually([&] {
    std::vector<std::byte> plain;
    encode(Presence{.sent = 1, .position = Vec3::Zero(), .hears = 8.0}, plain);
    std::vector<std::byte> sealed;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    ghost.seal(plain, net::crypto::Secret(session_key(7)),
               std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(), sealed);
    own_hub.impl().publish(subjects.who(cell_at(options.cells, Vec3::Zero())), sealed);
    most = std::max(most, a.status().contacts);
    return a.status().refused > before + 20;
  }));
  CHECK(most == 1);
  // He has the key of before, and is found by what he says under it.
  NatsTransport back(session.options(server.port(), 5));
  CHECK(eventually([&] { return linked(a, back) && linked(b, back) && back.group() == 1; }));
  CHECK(status_of(a, 3).connected == false);
}

/// All that is said to one cell, as the server has it.
class Recording {
 public:
  Recording(std::uint16_t port, const NatsOptions& options)
      : hub_(HubOptions{.servers = {{"127.0.0.1", port}}}),
        subject_(Subjects(options.prefix, options.member.scene_hash, options.cells)
                     .who(cell_at(options.cells, Vec3::Zero()))) {
    subscription_ = hub_.impl().subscribe(subject_, [this](std::span<const std::byte> bytes) {
      const std::scoped_lock lock(mutex_);
      if (records_) messages_.emplace_back(bytes.begin(), bytes.end());
    });
  }
  std::size_t size() {
    const std::scoped_lock lock(mutex_);
    return messages_.size();
  }
  void repeat() {
    std::vector<std::vector<std::byte>> all;
    {
      const std::scoped_lock lock(mutex_);
      records_ = false;
      all = messages_;
    }
    for (const auto& each : all) hub_.impl().publish(subject_, each);
  }

 private:
  NatsHub hub_;
  std::string subject_;
  std::mutex mutex_;
  bool records_ = true;
  std::vector<std::vector<std::byte>> messages_;
  NatsOwned<natsSubscription> subscription_;
};

TEST_CASE("nats: messages repeated by the server bring nobody back", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  const NatsOptions options = options_of(server.port(), 1);
  NatsTransport a(options);
  Recording recording(server.port(), options);
  // Two lives of one peer, both over.
  for (int life = 0; life < 2; ++life) {
    NatsTransport b(options_of(server.port(), 2));
    const std::size_t before = recording.size();
    REQUIRE(eventually([&] { return linked(a, b) && recording.size() > before + 10; }));
  }
  REQUIRE(eventually([&] { return a.status().contacts == 0; }));
  std::size_t most = 0;
  const std::uint64_t refused = a.status().refused;
  const std::size_t all = recording.size();
  for (int round = 1; round <= 3; ++round) {
    recording.repeat();
    REQUIRE(eventually([&] {
      most = std::max(most, a.status().contacts);
      return a.status().refused >= refused + static_cast<std::uint64_t>(round) * all;
    }));
  }
  CHECK(most == 0);
  // Its own words of before say nothing of how long they take.
  CHECK(a.status().lag < 400'000'000);
  // And who begins now hears nobody either.
  NatsTransport late(options_of(server.port(), 4));
  REQUIRE(eventually([&] { return linked(a, late) && late.status().contacts == 1; }));
  recording.repeat();
  CHECK(eventually([&] { return late.status().refused >= all; }));
  CHECK(late.status().contacts == 1);
}

}  // namespace
}  // namespace tandem::nats::group_change_test
