// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Clocks: whatever peers say of theirs, session time goes on at about the speed of the local clock.
#include <cstdlib>

#include "clock_sync.h"
#include "target.h"

namespace fuzz {

using namespace tandem::net;

void run(std::span<const std::byte> input) {
  Choices choices(input);
  std::int64_t now = 1'000'000'000;
  ClockSync sync(2, choices.byte() % 4 != 0, now, 77'000'000'000);
  SessionTime last = sync.now(now);
  bool synchronised = false;
  for (int steps = 0; !choices.done() && steps < 500; ++steps) {
    const unsigned what = choices.byte();
    const tandem::consensus::PeerId peer = 1 + what / 4 % 5;
    switch (what % 4) {
      case 0: {
        const auto sent = now - static_cast<std::int64_t>(choices.number(3)) * 16;
        const bool wild = choices.byte() % 4 == 0;
        const auto theirs = wild ? static_cast<std::int64_t>(choices.number(8))
                                 : now + static_cast<std::int64_t>(choices.number(2)) * 1000;
        const ClockSample sample{
            .sent = sent,
            .their_received = theirs,
            .their_sent = wild ? static_cast<std::int64_t>(choices.number(8)) : theirs + 1000,
            .received = now};
        sync.on_exchange(peer, sample,
                         {.sent = sample.their_sent,
                          .correction = static_cast<std::int64_t>(choices.number(wild ? 8 : 4)),
                          .rate = static_cast<std::int32_t>(choices.number(wild ? 4 : 2)),
                          .bound = static_cast<std::uint32_t>(choices.number(4)),
                          .rank = static_cast<std::uint8_t>(choices.byte() % 3)});
        break;
      }
      case 1:
        now += 50'000'000;
        sync.update(now);
        break;
      case 2:
        sync.lost(peer);
        break;
      default:
        now += static_cast<std::int64_t>(choices.number(3)) * 100;
        break;
    }
    const ClockStatus status = sync.status(now);
    require(status.error_bound >= 0);
    if (synchronised) require(status.now >= last);
    synchronised = status.synchronised;
    last = status.now;
    (void)sync.claim(now);
  }
}

std::vector<Bytes> seeds() {
  Bytes honest{std::byte{1}};
  for (int i = 0; i < 60; ++i) {
    for (const int value : {0, 0, 9, 0, 1, 20, 0, 1, 2, 3, 4, 5, 0, 9, 0, 0, 0, 2, 1}) {
      honest.push_back(static_cast<std::byte>(value));
    }
  }
  Bytes wild{std::byte{1}};
  for (int i = 0; i < 20; ++i) {
    wild.insert(wild.end(), {std::byte{0}, std::byte{0}, std::byte{9}, std::byte{0}, std::byte{0}});
    for (int k = 0; k < 33; ++k) wild.push_back(static_cast<std::byte>(0xff - k * i));
    wild.push_back(std::byte{1});
  }
  return {honest, wild};
}

}  // namespace fuzz
