// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/signals.h"

#include <algorithm>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {
constexpr std::uint32_t kMagic = 0x47495354;  // "TSIG" on the wire
constexpr std::size_t kBytes = 16;            // magic u32, code u32, time i64
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
  if (packet.bytes.size() != kBytes) return false;
  pbd::ByteReader in(packet.bytes);
  if (in.u32() != kMagic) return false;
  Signal signal;
  signal.code = in.u32();
  signal.time = in.i64();
  std::size_t& told = told_[packet.from];
  if (!plausible(signal.time, now_) || known_.size() >= kMaxSignals || told >= kMaxFromOne) {
    return true;
  }
  if (known_.insert(signal).second) ++told;
  return true;
}

void Signals::say(consensus::PeerId to, const Signal& signal) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  out.u32(kMagic);
  out.u32(signal.code);
  out.i64(signal.time);
  post(to, bytes, consensus::Delivery::Reliable);
}

}  // namespace tandem::demos
