// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/signals.h"

#include <algorithm>

#include "tandem/consensus/sender_clocks.h"
#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {
constexpr std::uint32_t kSignalMagic = 0x47495354;  // "TSIG" on the wire
constexpr std::size_t kSignalBytes = 24;  // magic u32, code u32, time i64, time of sending i64
}  // namespace

void Signals::update(consensus::SessionTime now) {
  now_ = now;
  std::vector<consensus::PeerId> company;
  for (const consensus::PeerStatus& peer : peers()) {
    if (!peer.connected) continue;
    company.push_back(peer.id);
    const bool newcomer = std::find(company_.begin(), company_.end(), peer.id) == company_.end();
    if (!newcomer) continue;
    for (const Signal& signal : known_) say(peer.id, signal);
  }
  company_ = std::move(company);
}

void Signals::raise(const Signal& signal) {
  known_.insert(signal);
  for (const consensus::PeerId peer : company_) say(peer, signal);
}

bool Signals::take(consensus::SessionTime now, Signal& signal) {
  for (const Signal& candidate : known_) {
    if (candidate.time > now) return false;
    if (!taken_.insert(candidate).second) continue;
    signal = candidate;
    return true;
  }
  return false;
}

bool Signals::hear(const consensus::Packet& packet) {
  if (packet.bytes.size() != kSignalBytes) return false;
  pbd::ByteReader in(packet.bytes);
  if (in.u32() != kSignalMagic) return false;
  Signal signal;
  signal.code = in.u32();
  signal.time = in.i64();
  signal.time = dated(packet, signal.time, in.i64());
  std::size_t& told = told_[packet.from];
  if (!plausible(signal.time, now_) || knows(signal) || known_.size() >= kMaxSignals ||
      told >= kMaxFromOne) {
    return true;
  }
  if (known_.insert(signal).second) ++told;
  return true;
}

consensus::SessionTime Signals::dated(const consensus::Packet& packet, consensus::SessionTime time,
                                      consensus::SessionTime said) const {
  if (timestamps_ == consensus::TimestampSource::Sender) return time;
  const consensus::Arrival at = consensus::arrival_of(packet, peers(), now_);
  return consensus::shifted(time, consensus::SenderClocks::guess(said, at.received, at.round_trip));
}

bool Signals::knows(const Signal& signal) const {
  if (timestamps_ == consensus::TimestampSource::Sender) return false;  // the same time then
  return std::any_of(known_.begin(), known_.end(), [&](const Signal& known) {
    return known.code == signal.code && known.time - signal.time < kSameSignal &&
           signal.time - known.time < kSameSignal;
  });
}

void Signals::say(consensus::PeerId to, const Signal& signal) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  out.u32(kSignalMagic);
  out.u32(signal.code);
  out.i64(signal.time);
  out.i64(now_);
  post(to, bytes, consensus::Delivery::Reliable);
}

}  // namespace tandem::demos
