// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/rendezvous.h"

#include <algorithm>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {

constexpr std::uint32_t kHelloMagic = 0x4f4d4454;  // "TDMO" on the wire; no packet of a session
constexpr std::size_t kHelloBytes = 20;            // magic u32, epoch i64, time of sending i64

}  // namespace

void Rendezvous::update(consensus::SessionTime now) {
  now_ = now;
  company_ = peers();
  const bool speak = now >= next_word_;
  if (speak) next_word_ = now + kInterval;
  connected_ = false;
  bool all_heard = true;
  bool lowest = true;
  for (const consensus::PeerStatus& peer : company_) {
    if (!peer.connected) {
      heard_.erase(peer.id);
      view_.forget_hands(peer.id);
      continue;
    }
    connected_ = true;
    if (speak) say(peer.id);
    all_heard = all_heard && heard_.contains(peer.id);
    lowest = lowest && self() < peer.id;
  }
  if (epoch_) return;
  for (const auto& [peer, epoch] : heard_) {
    if (epoch != 0) epoch_ = epoch_ ? std::min(*epoch_, epoch) : epoch;
  }
  if (!epoch_ && connected_ && all_heard && lowest) {
    epoch_ = now + kLead;
    next_word_ = now;  // send it at once, in the next round
  }
}

void Rendezvous::drain(std::vector<consensus::Packet>& out) {
  const std::size_t first = out.size();
  SideChannel::drain(out);
  for (std::size_t i = first; i < out.size(); ++i) {
    std::optional<consensus::Arrival> arrival;
    if (timestamps_ == consensus::TimestampSource::Arrival) {
      arrival = consensus::arrival_of(out[i], company_, now_);
    }
    view_.look(out[i].from, out[i].bytes, arrival);
  }
}

bool Rendezvous::hear(const consensus::Packet& packet) {
  if (packet.bytes.size() != kHelloBytes) return false;
  pbd::ByteReader in(packet.bytes);
  if (in.u32() != kHelloMagic) return false;
  consensus::SessionTime epoch = in.i64();
  const consensus::SessionTime said = in.i64();
  if (epoch != 0 && timestamps_ == consensus::TimestampSource::Arrival) {
    const consensus::Arrival at = consensus::arrival_of(packet, company_, now_);
    epoch =
        consensus::shifted(epoch, consensus::SenderClocks::guess(said, at.received, at.round_trip));
  }
  // An epoch days away is invalid.
  if (epoch == 0 || plausible(epoch, now_)) heard_[packet.from] = epoch;
  return true;
}

void Rendezvous::say(consensus::PeerId to) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  out.u32(kHelloMagic);
  out.i64(epoch_.value_or(0));
  out.i64(now_);
  post(to, bytes, consensus::Delivery::Newest);
}

}  // namespace tandem::demos
