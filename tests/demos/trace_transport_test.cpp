// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/random.h"
#include "support/catch.h"
#include "trace/transports.h"

namespace tandem::demos::trace_transport_test {
namespace {

using consensus::Delivery;

/// Says something else at every call.
class Moody final : public consensus::Transport {
 public:
  consensus::PeerId self() const override { return 7; }
  bool post(consensus::PeerId, std::span<const std::byte>, Delivery) override {
    return random_.below(3) != 0;
  }
  std::size_t max_packet_bytes(Delivery) const override { return 500 + random_.below(3); }
  void drain(std::vector<consensus::Packet>& out) override {
    for (std::size_t n = random_.below(3); n > 0; --n) {
      out.push_back({.from = 1 + random_.below(2),
                     .bytes = std::vector<std::byte>(random_.below(20)),
                     .received = static_cast<consensus::SessionTime>(random_.below(1000))});
    }
  }
  void drop(consensus::PeerId, const std::string&) override {}
  std::vector<consensus::PeerStatus> peers() const override {
    std::vector<consensus::PeerStatus> result(1 + random_.below(2));
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i].id = 1 + i;
      result[i].connected = random_.below(4) != 0;
      result[i].kbit_per_s = 100.0 * static_cast<double>(random_.below(2));
      result[i].round_trip = static_cast<std::int64_t>(random_.below(2)) - 1;
    }
    return result;
  }

 private:
  mutable Random random_{5};
};

/// Keeps what it hears by phase.
class Phases final : public TraceSink {
 public:
  void packets(std::uint64_t call, std::span<const consensus::Packet> packets) override {
    TraceRecord record;
    record.kind = TraceKind::Packets;
    record.call = call;
    record.packets.assign(packets.begin(), packets.end());
    all.back().push_back(record);
  }
  void answer(const TraceRecord& record) override { all.back().push_back(record); }

  std::vector<std::vector<TraceRecord>> all;
};

/// Some calls of a phase, and all that was answered, in words.
std::string ask(consensus::Transport& transport, Random& random) {
  std::string answers;
  for (std::size_t n = random.below(30); n > 0; --n) {
    const Delivery delivery = random.below(2) == 0 ? Delivery::Newest : Delivery::Reliable;
    switch (random.below(5)) {
      case 0:
        answers += transport.post(1, {}, delivery) ? "taken " : "refused ";
        break;
      case 1:
        answers += std::to_string(transport.max_packet_bytes(delivery)) + ' ';
        break;
      case 2: {
        std::vector<consensus::Packet> packets(1);
        transport.drain(packets);
        for (const auto& packet : packets) {
          answers += std::to_string(packet.from) + ':' + std::to_string(packet.bytes.size()) + '@' +
                     std::to_string(packet.received) + ' ';
        }
        break;
      }
      case 3:
        transport.drop(2, "because");
        break;
      default:
        for (const auto& peer : transport.peers()) {
          answers += std::to_string(peer.id) + (peer.connected ? "+" : "-") +
                     std::to_string(peer.kbit_per_s) + '/' + std::to_string(peer.round_trip) + ' ';
        }
    }
  }
  return answers;
}

TEST_CASE("trace: a transport that is replayed answers every call as it did", "[demos][unit]") {
  Moody moody;
  Phases phases;
  TracingTransport tracing(moody, phases);
  constexpr int kPhases = 200;
  std::vector<std::string> answers;
  std::vector<std::uint64_t> sent;
  Random calls(9);
  for (int i = 0; i < kPhases; ++i) {
    phases.all.emplace_back();
    tracing.begin_phase();
    answers.push_back(ask(tracing, calls));
    sent.push_back(tracing.sent().take());
  }
  ReplayTransport replay(7);
  CHECK(replay.self() == tracing.self());
  Random again(9);
  for (std::size_t i = 0; i < kPhases; ++i) {
    INFO("phase " << i);
    replay.begin_phase(phases.all[i]);
    REQUIRE(ask(replay, again) == answers[i]);
    CHECK(replay.sent().take() == sent[i]);
    CHECK_FALSE(replay.left_over());
  }
  // A peer that does not ask leaves packets over.
  std::size_t left_over = 0;
  for (const auto& phase : phases.all) {
    replay.begin_phase(phase);
    left_over += replay.left_over() ? 1 : 0;
  }
  CHECK(left_over > 100);
}

}  // namespace
}  // namespace tandem::demos::trace_transport_test
