// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/sender_clocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/ranges.h"

namespace tandem::consensus {
namespace {

/// ns: a sample further from the estimate is of another clock, or of a delayed packet.
constexpr SessionTime kAstray = 250'000'000;
/// ns: for this long the offset follows at once.
constexpr SessionTime kAtOnce = 1'000'000'000;

/// a - b, clamped to +-`most`, for times within kMaxStamp of 0.
SessionTime difference(SessionTime a, SessionTime b, SessionTime most = kMaxStamp) {
  const SessionTime half = a / 2 - b / 2;
  if (half > most / 2 - 1) return most;
  if (half < 1 - most / 2) return -most;
  return a - b;
}

/// Arrival less stamp, with room to add or subtract a round trip.
SessionTime lateness(SessionTime received, SessionTime stamp) {
  return difference(received, stamp, kMaxStamp - 2 * SenderClocks::kLongestWay);
}

/// Visit the stamps made when sending.
template <class Packet, class Look>
void stamps_of_sending(Packet& packet, const Look& look) {
  for (auto& state : packet.states) look(state.stamp);
  for (auto& state : packet.compact) look(state.update.stamp);
  for (auto& alive : packet.alive) look(alive.stamp);
}

/// Visit all other stamps.
template <class Packet, class Look>
void other_stamps(Packet& packet, const Look& look) {
  for (auto& spring : packet.springs) look(spring.stamp);
  for (auto& leave : packet.leaves) look(leave.stamp);
  for (auto& ownership : packet.ownership) look(ownership.stamp);
  for (auto& anchor : packet.anchors) look(anchor.stamp);
  for (auto& act : packet.acts) look(act.stamp);
  for (auto& receipt : packet.receipts) look(receipt.stamp);
}

}  // namespace

Arrival arrival_of(const Packet& packet, std::span<const PeerStatus> peers, SessionTime now) {
  const bool said = packet.received != std::numeric_limits<SessionTime>::min();
  const auto sender = ranges::find(peers, packet.from, &PeerStatus::id);
  return {.received = said ? packet.received : now,
          .round_trip = sender != peers.end() ? sender->round_trip : -1};
}

SessionTime shifted(SessionTime stamp, SessionTime shift) {
  if (shift > 0 && stamp > kMaxStamp - shift) return kMaxStamp;
  if (shift < 0 && stamp < -kMaxStamp - shift) return -kMaxStamp;
  return stamp + shift;
}

void shift_stamps(DecodedPacket& packet, SessionTime shift) {
  const auto move = [shift](SessionTime& stamp) { stamp = shifted(stamp, shift); };
  stamps_of_sending(packet, move);
  other_stamps(packet, move);
}

std::optional<SessionTime> newest_stamp(const DecodedPacket& packet) {
  std::optional<SessionTime> newest;
  stamps_of_sending(
      packet, [&newest](SessionTime stamp) { newest = newest ? std::max(*newest, stamp) : stamp; });
  return newest;
}

SessionTime newest_stamp_of_others(const DecodedPacket& packet) {
  SessionTime newest = -kMaxStamp;
  other_stamps(packet, [&newest](SessionTime stamp) { newest = std::max(newest, stamp); });
  return newest == -kMaxStamp ? 0 : newest;
}

struct SenderClocks::Sender {
  PeerId peer = 0;
  SessionTime shift = 0;         ///< ns
  SessionTime began = 0;         ///< ns, own clock
  SessionTime last = 0;          ///< ns, own clock, of the last sample
  bool knows_way = false;        ///< whether a round trip was known
  std::size_t count = 0;         ///< samples so far
  int astray = 0;                ///< successive samples that do not fit
  SessionTime astray_since = 0;  ///< ns, own clock
  SessionTime stamp = 0;         ///< of the current packets
  double sum = 0.0;              ///< ns, of these, sum of lateness relative to `first`
  SessionTime first = 0;         ///< ns, arrival less stamp of the first of these
  std::uint64_t packets = 0;     ///< number of these
  std::array<SessionTime, kWindow> samples = {};  ///< ns, arrival less stamp

  void restart(SessionTime late, SessionTime half, SessionTime received) {
    shift = late - half;
    began = last = received;
    count = 0;
    astray = 0;
  }

  void close(SessionTime half, SessionTime received) {
    const SessionTime late = first + std::llround(sum / static_cast<double>(packets));
    const SessionTime off = difference(late - half, shift);
    if (count > 0 && std::abs(off) > kAstray) {
      if (astray++ == 0) astray_since = received;
      const bool over = off < 0 || difference(received, astray_since) >= kAstrayFor;
      if (astray < kAstrayCount || !over) return;
      restart(late, half, received);
    }
    astray = 0;
    samples[count++ % kWindow] = late;
    std::array<SessionTime, kWindow> sorted = samples;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(count, kWindow));
    const auto middle = sorted.begin() + (end - sorted.begin()) / 2;
    std::nth_element(sorted.begin(), middle, end);
    const auto missing = static_cast<double>(difference(*middle - half, shift));
    const auto passed = static_cast<double>(std::max<SessionTime>(difference(received, last), 0));
    const auto age = static_cast<double>(difference(received, began));
    last = std::max(last, received);
    // At first the mean of all medians, then an exponential average.
    const double part = passed < age ? passed / std::min(age, kSettling * 1e9) : 1.0;
    double step = std::min(part, 1.0) * missing;
    if (difference(received, began) > kAtOnce)
      step = std::clamp(step, -kSlew * passed, kSlew * passed);
    shift += std::llround(step);
  }
};

SenderClocks::SenderClocks() = default;
SenderClocks::~SenderClocks() = default;

SessionTime SenderClocks::hear(PeerId from, SessionTime newest, SessionTime received,
                               SessionTime round_trip) {
  const SessionTime half = std::clamp(round_trip, SessionTime{0}, kLongestWay) / 2;
  received = std::clamp(received, -kMaxStamp, kMaxStamp);
  const SessionTime late = lateness(received, newest);
  auto at = ranges::lower_bound(senders_, from, &Sender::peer);
  if (at == senders_.end() || at->peer != from) {
    at = senders_.insert(at, Sender{.peer = from, .knows_way = round_trip >= 0});
    at->restart(late, half, received);
  }
  Sender& sender = *at;
  if (round_trip >= 0 && !sender.knows_way) {
    sender.knows_way = true;
    sender.restart(sender.shift, half, received);
  }
  // Packets with one stamp are one sample: else the window might cover only a few steps.
  if (sender.packets > 0 && sender.stamp != newest) {
    sender.close(half, received);
    sender.packets = 0;
  }
  if (sender.packets == 0) {
    sender.stamp = newest;
    sender.first = late;
    sender.sum = 0.0;
  }
  ++sender.packets;
  sender.sum += static_cast<double>(difference(late, sender.first));
  return sender.shift;
}

void SenderClocks::forget(PeerId from) {
  std::erase_if(senders_, [from](const Sender& sender) { return sender.peer == from; });
}

std::optional<SessionTime> SenderClocks::shift(PeerId from) const {
  const auto at = ranges::lower_bound(senders_, from, &Sender::peer);
  if (at == senders_.end() || at->peer != from) return std::nullopt;
  return at->shift;
}

SessionTime SenderClocks::guess(SessionTime newest, SessionTime received, SessionTime round_trip) {
  received = std::clamp(received, -kMaxStamp, kMaxStamp);
  return lateness(received, newest) - std::clamp(round_trip, SessionTime{0}, kLongestWay) / 2;
}

}  // namespace tandem::consensus
