// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/transports.h"

#include <algorithm>
#include <bit>

namespace tandem::demos {

bool same_in_trace(std::span<const consensus::PeerStatus> a,
                   std::span<const consensus::PeerStatus> b) {
  const auto same = [](const consensus::PeerStatus& x, const consensus::PeerStatus& y) {
    return x.id == y.id && x.connected == y.connected &&
           std::bit_cast<std::uint64_t>(x.kbit_per_s) ==
               std::bit_cast<std::uint64_t>(y.kbit_per_s) &&
           x.round_trip == y.round_trip && x.dropped_queue_full == y.dropped_queue_full &&
           x.rejected == y.rejected;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

bool TracingTransport::post(consensus::PeerId to, std::span<const std::byte> bytes,
                            consensus::Delivery delivery) {
  const bool taken = inner_.post(to, bytes, delivery);
  sent_.post(to, bytes, delivery);
  if (!taken) {
    answer_.kind = TraceKind::Refused;
    answer_.call = calls_.posts;
    sink_.answer(answer_);
  }
  ++calls_.posts;
  return taken;
}

std::size_t TracingTransport::max_packet_bytes(consensus::Delivery delivery) const {
  const std::size_t limit = inner_.max_packet_bytes(delivery);
  const auto way = static_cast<std::size_t>(delivery);
  if (limit != limits_[way]) {
    limits_[way] = limit;
    answer_.kind = TraceKind::Limit;
    answer_.call = calls_.limits[way];
    answer_.delivery = delivery;
    answer_.bytes = limit;
    sink_.answer(answer_);
  }
  ++calls_.limits[way];
  return limit;
}

void TracingTransport::drain(std::vector<consensus::Packet>& out) {
  const std::size_t first = out.size();
  inner_.drain(out);
  const auto fresh = std::span<const consensus::Packet>(out).subspan(first);
  if (!fresh.empty()) sink_.packets(calls_.drains, fresh);
  ++calls_.drains;
}

void TracingTransport::drop(consensus::PeerId peer, const std::string& reason) {
  inner_.drop(peer, reason);
  sent_.drop(peer);
}

std::vector<consensus::PeerStatus> TracingTransport::peers() const {
  std::vector<consensus::PeerStatus> result = inner_.peers();
  if (!same_in_trace(result, peers_)) {
    peers_ = result;
    answer_.kind = TraceKind::Peers;
    answer_.call = calls_.looks;
    answer_.peers = result;
    sink_.answer(answer_);
  }
  ++calls_.looks;
  return result;
}

void ReplayTransport::begin_phase(std::span<const TraceRecord> answers) {
  answers_ = answers;
  calls_ = {};
}

bool ReplayTransport::left_over() const {
  return std::any_of(answers_.begin(), answers_.end(), [this](const TraceRecord& answer) {
    return answer.kind == TraceKind::Packets && answer.call >= calls_.drains;
  });
}

const TraceRecord* ReplayTransport::find(TraceKind kind, std::uint64_t call) const {
  const auto found =
      std::find_if(answers_.begin(), answers_.end(), [kind, call](const TraceRecord& answer) {
        return answer.kind == kind && answer.call == call;
      });
  return found == answers_.end() ? nullptr : &*found;
}

bool ReplayTransport::post(consensus::PeerId to, std::span<const std::byte> bytes,
                           consensus::Delivery delivery) {
  sent_.post(to, bytes, delivery);
  return find(TraceKind::Refused, calls_.posts++) == nullptr;
}

std::size_t ReplayTransport::max_packet_bytes(consensus::Delivery delivery) const {
  const auto way = static_cast<std::size_t>(delivery);
  const std::uint64_t call = calls_.limits[way]++;
  for (const TraceRecord& answer : answers_) {
    const bool meant = answer.kind == TraceKind::Limit && answer.delivery == delivery;
    if (meant && answer.call == call) limits_[way] = answer.bytes;
  }
  return static_cast<std::size_t>(limits_[way]);
}

void ReplayTransport::drain(std::vector<consensus::Packet>& out) {
  const TraceRecord* const came = find(TraceKind::Packets, calls_.drains++);
  if (came != nullptr) out.insert(out.end(), came->packets.begin(), came->packets.end());
}

void ReplayTransport::drop(consensus::PeerId peer, const std::string& /*reason*/) {
  sent_.drop(peer);
}

std::vector<consensus::PeerStatus> ReplayTransport::peers() const {
  const TraceRecord* const told = find(TraceKind::Peers, calls_.looks++);
  if (told != nullptr) peers_ = told->peers;
  return peers_;
}

}  // namespace tandem::demos
