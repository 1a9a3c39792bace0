// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/link_words.h"

#include <algorithm>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {

constexpr std::uint32_t kMagic = 0x44575454;  // "TTWD" on the wire; no packet of a session
// magic u32, number u32, own time i64, time in the newest word received i64 (0: none), its age i64.
constexpr std::size_t kBytes = 32;
constexpr std::uint32_t kReordered = 64;   // words: a number further back means a new process
constexpr std::uint32_t kFurthest = 3000;  // the same for a number ahead
constexpr std::int64_t kLongestRound = 60'000'000'000;  // ns: no round trip is longer

}  // namespace

void LinkWords::update(std::int64_t now) {
  now_ = now;
  if (now < next_word_) return;
  next_word_ = now + kInterval;
  const bool turn = now >= next_period_;
  if (turn) next_period_ = now + kPeriod;
  for (const consensus::PeerStatus& peer : peers()) {
    if (!peer.connected) {
      links_.erase(peer.id);
      continue;
    }
    Link& link = links_[peer.id];
    if (turn) {
      link.before = link.now;
      link.now = {};
    }
    std::vector<std::byte> bytes;
    pbd::ByteWriter out(bytes);
    out.u32(kMagic);
    out.u32(++link.said);
    out.i64(now);
    out.i64(link.newest ? link.their_time : 0);
    out.i64(link.newest ? now - link.heard_at : 0);
    post(peer.id, bytes, consensus::Delivery::Newest);
  }
}

LinkFigures LinkWords::figures(consensus::PeerId peer) const {
  const auto found = links_.find(peer);
  if (found == links_.end()) return {};
  const Link& link = found->second;
  LinkFigures result;
  const auto expected = static_cast<double>(link.now.expected + link.before.expected);
  const auto heard = static_cast<double>(link.now.heard + link.before.heard);
  if (expected > 0.0) result.loss = std::max(0.0, 1.0 - heard / expected);
  if (link.round_trip >= 0) result.round_trip = 1e-9 * static_cast<double>(link.round_trip);
  return result;
}

bool LinkWords::hear(const consensus::Packet& packet) {
  if (packet.bytes.size() != kBytes) return false;
  pbd::ByteReader in(packet.bytes);
  if (in.u32() != kMagic) return false;
  const auto found = links_.find(packet.from);
  if (found == links_.end()) return true;
  Link& link = found->second;
  const std::uint32_t number = in.u32();
  const std::int64_t theirs = in.i64();
  const std::int64_t ours = in.i64();
  const std::int64_t held = in.i64();
  const bool newer = !link.newest || number > *link.newest || *link.newest - number > kReordered;
  count(link, number);
  if (!newer) return true;
  link.their_time = theirs;
  link.heard_at = now_;
  // Accept only a plausible echo of our own time.
  const bool answered =
      ours > now_ - kLongestRound && ours <= now_ && held >= 0 && held <= now_ - ours;
  if (!answered) return true;
  const std::int64_t sample = now_ - ours - held;
  link.round_trip = link.round_trip < 0 ? sample : link.round_trip + (sample - link.round_trip) / 8;
  return true;
}

void LinkWords::count(Link& link, std::uint32_t number) {
  if (link.newest && number <= *link.newest && *link.newest - number <= kReordered) {
    // Late or duplicated.
    if (number != *link.newest) ++link.now.heard;
    return;
  }
  const bool follows = link.newest && number > *link.newest && number - *link.newest <= kFurthest;
  link.now.expected += follows ? number - *link.newest : 1;
  ++link.now.heard;
  link.newest = number;
}

}  // namespace tandem::demos
