// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/link_words.h"

#include <vector>

#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/bytes.h"

namespace tandem::demos::link_words_test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Two peers that look each 10 ms. Their clocks have nothing to do with each other.
struct Pair {
  explicit Pair(const consensus::LinkOptions& link)
      : network(link, 3), a(network.transport(1)), b(network.transport(2)) {}
  void run(std::int64_t from, std::int64_t to) {
    for (std::int64_t now = from; now < to; now += 10 * kMs) {
      network.advance_to(now);
      a.update(now + 5'000'000 * kMs);
      a.drain(packets);
      b.update(now + 77 * kMs);
      b.drain(packets);
    }
  }
  consensus::VirtualNetwork network;
  LinkWords a, b;
  std::vector<consensus::Packet> packets;
};

TEST_CASE("link words: loss and round trip are those of the link", "[demos][unit]") {
  Pair pair({.latency = 0.1, .loss = 0.25});
  pair.run(0, 119'000 * kMs);
  for (const LinkFigures& figures : {pair.a.figures(2), pair.b.figures(1)}) {
    // About 590 words: the standard deviation is 0.018.
    CHECK(figures.loss > 0.16);
    CHECK(figures.loss < 0.34);
    // Twice the latency, and up to a look of 10 ms at each end.
    CHECK(figures.round_trip >= 0.199);
    CHECK(figures.round_trip <= 0.221);
  }
  CHECK(pair.packets.empty());  // no word gets through
}

TEST_CASE("link words: duplicates and reordering do not count as loss", "[demos][unit]") {
  Pair pair({.latency = 0.1, .jitter = 0.09, .duplicate = 0.5, .reorder = 0.5});
  pair.run(0, 30'000 * kMs);
  CHECK(pair.a.figures(2).loss < 0.02);
}

TEST_CASE("link words: lies are bounded", "[demos][fault]") {
  consensus::VirtualNetwork network;
  LinkWords honest(network.transport(1));
  consensus::Transport& liar = network.transport(2);
  std::vector<consensus::Packet> packets;
  std::int64_t now = 0;
  const auto say = [&](std::uint32_t number, std::int64_t echo, std::int64_t held) {
    std::vector<std::byte> bytes;
    pbd::ByteWriter out(bytes);
    out.u32(0x44575454);
    out.u32(number);
    out.i64(INT64_MIN);
    out.i64(echo);
    out.i64(held);
    liar.post(1, bytes, consensus::Delivery::Newest);
    now += 300 * kMs;
    network.advance_to(now);
    honest.update(now);
    honest.drain(packets);
  };
  for (const std::int64_t lie : {INT64_MIN, std::int64_t{-1}, std::int64_t{1}, INT64_MAX}) {
    for (const std::uint32_t number : {0U, 1U, 0xffffffffU}) say(number, lie, lie);
    say(7, now, INT64_MAX);
    say(8, now, INT64_MIN);
  }
  const LinkFigures figures = honest.figures(2);
  CHECK(figures.loss >= 0.0);
  CHECK(figures.loss <= 1.0);
  CHECK(figures.round_trip < 60.0);
}

}  // namespace
}  // namespace tandem::demos::link_words_test
