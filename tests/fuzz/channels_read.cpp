// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A connection after decryption: a member says what it likes, in any order and number, while this
// end posts, sends, drains and waits. What is kept stays within its limits.
#include "channels.h"
#include "packet_protection.h"
#include "target.h"

namespace fuzz {

using namespace tandem::net;
using tandem::consensus::Delivery;

namespace {

constexpr ChannelOptions kOptions{.state_queue_bytes = 4096,
                                  .state_life = 200'000'000,
                                  .reliable_queue_bytes = 8192,
                                  .max_message_bytes = 2048,
                                  .receive_queue_bytes = 8192};

// A packet of the input: u8 2, u8 gap in numbers, u16 length, bytes.
void add_packet(const Bytes& plain, Bytes& out) {
  out.push_back(std::byte{2});
  out.push_back(std::byte{1});
  out.push_back(static_cast<std::byte>(plain.size()));
  out.push_back(static_cast<std::byte>(plain.size() >> 8));
  out.insert(out.end(), plain.begin(), plain.end());
}

}  // namespace

void run(std::span<const std::byte> input) {
  Choices choices(input);
  Channels channels(kOptions, kMaxDatagram);
  std::int64_t now = 0;
  std::uint64_t sent = 0;
  std::uint64_t had = 0;
  std::vector<Channels::Message> messages;
  Bytes out;
  const ClockClaim clock{.sent = 1, .correction = 2, .rate = 3, .bound = 4, .rank = 1};
  for (int steps = 0; !choices.done() && steps < 400; ++steps) {
    switch (choices.byte() % 7) {
      case 0:
        (void)channels.post_state(Bytes(choices.byte()), 1100, now);
        break;
      case 1:
        (void)channels.post_reliable(Bytes(choices.number(2) % 3000));
        break;
      case 2: {
        had += 1 + choices.byte() % 4;
        const auto plain = choices.bytes(choices.number(2) % 1200);
        // Over for good, as a connection would be.
        if (channels.read(had, plain, now) == Channels::Read::Malformed) return;
        break;
      }
      case 3:
        out.clear();
        channels.write(++sent, 1171, now, choices.byte() % 2 == 0 ? &clock : nullptr, out);
        require(out.size() <= 1171);
        break;
      case 4:
        now += static_cast<std::int64_t>(choices.number(3)) * 1000;
        channels.on_time(now);
        (void)channels.has_content(now);
        break;
      case 5:
        messages.clear();
        channels.inbox().drain(messages);
        for (const auto& message : messages) {
          require(message.delivery != Delivery::Reliable ||
                  message.bytes.size() <= kOptions.max_message_bytes);
        }
        break;
      default:
        channels.resume(channels.take_reliable());
        (void)channels.inbox().take_told();
        (void)channels.take_exchange();
        (void)channels.take_feedback();
        break;
    }
    require(channels.reliable().cost() <= kOptions.reliable_queue_bytes);
    require(channels.rtt().smoothed() >= 0);
  }
}

std::vector<Bytes> seeds() {
  // An honest talk: both kinds are posted and sent, acknowledged, drained.
  std::vector<Bytes> out;
  Channels other(kOptions, kMaxDatagram);
  for (int i = 0; i < 3; ++i) {
    Bytes script;
    Bytes plain;
    for (int k = 0; k < 4; ++k) {
      (void)other.post_state(Bytes(50), 1100, k);
      (void)other.post_reliable(Bytes(700));
      other.tell({.peer = 9, .address = {.ip = {3}, .port = 4}});
      const ClockClaim clock{.sent = 1000 * k, .correction = 4};
      plain.clear();
      other.write(static_cast<std::uint64_t>(4 * i + k + 1), 1171, k, &clock, plain);
      add_packet(plain, script);
      for (const int op : {0, 60, 1, 200, 1, 3, 0, 4, 9, 0, 0, 5}) {
        script.push_back(static_cast<std::byte>(op));
      }
    }
    script.push_back(std::byte{6});
    // And an acknowledgement of what the script itself has sent.
    Bytes ack;
    encode(ChannelHeader{.ack = 3, .ack_bits = 3, .ack_delay = 1}, ack);
    add_packet(ack, script);
    out.push_back(script);
  }
  return out;
}

}  // namespace fuzz
