// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is far away comes as summaries of cells, from one of those who are there.
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "nats/peers.h"
#include "tandem/consensus/update.h"
#include "tandem/net/membership.h"

namespace tandem::nats::summary_test {
namespace {

using namespace testing;

/// Cells of 2, 8 and 32 m.
NatsOptions far_options(std::uint16_t port, PeerId self) {
  NatsOptions out = options_of(port, self);
  out.cells.edge = 2.0;
  out.cells.near = 2.0;
  out.cells.slack = 0.2;
  out.cells.levels = 3;
  return out;
}

std::vector<std::byte> packet_of(const char* name) {
  consensus::StateUpdate update;
  update.id = consensus::SharedId::from_name(name);
  update.influence = 0.3F;
  update.stamp = 1;
  std::vector<std::byte> out;
  REQUIRE(consensus::encode(std::span(&update, 1), out) == 1);
  return out;
}

TEST_CASE("nats: one peer of a far cell sends its summary, and another if that one goes",
          "[nats]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(far_options(server.port(), 1));
  a.set_position(Vec3(1.0, 1.0, 0.0));
  // Three in one cell of 8 m, out of hearing of `a`.
  std::vector<std::unique_ptr<NatsTransport>> far;
  for (PeerId id = 10; id < 13; ++id) {
    far.push_back(std::make_unique<NatsTransport>(far_options(server.port(), id)));
    far.back()->set_position(Vec3(11.0 + 0.3 * static_cast<double>(id - 10), 1.0, 0.0));
    REQUIRE(far.back()->set_summary(1, packet_of("far")));
  }
  CHECK_FALSE(a.set_summary(0, {}));
  CHECK_FALSE(a.set_summary(1, std::vector<std::byte>(NatsTransport::kMaxSummaryBytes + 1)));
  const Cell cell = cell_at({.edge = 2.0}, Vec3(11.0, 1.0, 0.0), 1);
  std::vector<CellSummary> heard;
  std::vector<Packet> packets;
  const auto look = [&] {
    heard.clear();
    a.take_summaries(heard);
    a.drain(packets);
  };
  const auto says = [&](PeerId who, std::uint32_t people) {
    return std::ranges::any_of(heard, [&](const CellSummary& each) {
      return each.cell == cell && each.from == who && each.people == people;
    });
  };
  REQUIRE(eventually([&] {
    look();
    return says(10, 3);
  }));
  CHECK(a.peers().empty());  // nobody is connected for that
  // A receiver cannot tell it from a peer.
  REQUIRE(!packets.empty());
  consensus::DecodedPacket decoded;
  REQUIRE(consensus::decode(packets.back().bytes, decoded).ok());
  CHECK(decoded.states.at(0).id == consensus::SharedId::from_name("far"));
  CHECK(decoded.states.at(0).influence == 0.3F);
  // The next one up has heard of all of them, and of `a`.
  REQUIRE(eventually([&] {
    look();
    return a.speaks(2) &&
           std::ranges::none_of(far, [](const auto& each) { return each->speaks(2); });
  }));
  CHECK(far[0]->speaks(1));
  far.erase(far.begin());
  REQUIRE(eventually([&] {
    look();
    return says(11, 2);
  }));
}

TEST_CASE("nats: where speakers are listed nobody else is believed", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  const net::Key secret = net::make_key();
  const auto options = [&](PeerId self) {
    NatsOptions out = far_options(server.port(), self);
    out.speakers = {{10, net::organiser_public_key(secret)}};
    return out;
  };
  NatsTransport a(options(1));
  // It does not know whom the others believe, and speaks with the lowest id of those in its cell.
  NatsOptions lying = far_options(server.port(), 5);
  lying.speaker = net::make_key();
  NatsTransport liar(lying);
  NatsOptions honest = options(10);
  honest.speaker = secret;
  NatsTransport speaker(honest);
  for (NatsTransport* each : {&liar, &speaker}) each->set_position(Vec3(11.0, 1.0, 0.0));
  std::vector<CellSummary> heard;
  std::set<PeerId> who;
  REQUIRE(eventually([&] {
    heard.clear();
    a.take_summaries(heard);
    for (const CellSummary& each : heard) who.insert(each.from);
    return who.contains(10) && liar.speaks(1) && a.status().refused > 3;
  }));
  CHECK_FALSE(who.contains(5));
  CHECK_FALSE(a.speaks(1));
}

}  // namespace
}  // namespace tandem::nats::summary_test
