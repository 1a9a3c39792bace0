// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"
#include "trace/record.h"
#include "trace/stage_hashes.h"

namespace tandem::demos {

/// Calls of a transport in one phase, by kind: an answer finds its call even if a changed program
/// makes other calls between.
struct TransportCalls {
  std::uint64_t drains = 0;
  std::uint64_t looks = 0;  ///< of peers()
  std::uint64_t posts = 0;
  std::array<std::uint64_t, 2> limits{};  ///< of max_packet_bytes(), by delivery
};

/// True if two lists of peers are equal in the fields of traces.
bool same_in_trace(std::span<const consensus::PeerStatus> a,
                   std::span<const consensus::PeerStatus> b);

/// Receives the answers heard by a TracingTransport.
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  /// `call` is its index in the phase. Must not throw.
  virtual void packets(std::uint64_t call, std::span<const consensus::Packet> packets) = 0;
  virtual void answer(const TraceRecord& record) = 0;
};

/// Records each answer that differs from the reader's default: no packets, posts accepted, all else
/// unchanged.
/// @par Thread safety  One object: one thread at a time.
class TracingTransport final : public consensus::Transport {
 public:
  /// Both must outlive it.
  TracingTransport(consensus::Transport& inner, TraceSink& sink) : inner_(inner), sink_(sink) {}

  void begin_phase() { calls_ = {}; }
  SentHash& sent() { return sent_; }

  // consensus::Transport
  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;

 private:
  consensus::Transport& inner_;
  TraceSink& sink_;
  SentHash sent_;
  // Queries change only the record of the answers.
  mutable TransportCalls calls_;
  mutable TraceRecord answer_;
  mutable std::vector<consensus::PeerStatus> peers_;
  mutable std::array<std::uint64_t, 2> limits_{};
};

/// Answers as recorded. Counts of packets, bytes and reasons are not in traces: zero and empty
/// here.
/// @par Thread safety  One object: one thread at a time.
class ReplayTransport final : public consensus::Transport {
 public:
  explicit ReplayTransport(consensus::PeerId self) : self_(self) {}

  /// The answers of the coming phase; must outlive it.
  void begin_phase(std::span<const TraceRecord> answers);
  /// True if packets of the phase were never asked for.
  bool left_over() const;
  SentHash& sent() { return sent_; }

  // consensus::Transport
  consensus::PeerId self() const override { return self_; }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;

 private:
  const TraceRecord* find(TraceKind kind, std::uint64_t call) const;

  consensus::PeerId self_;
  std::span<const TraceRecord> answers_;
  SentHash sent_;
  mutable TransportCalls calls_;
  mutable std::vector<consensus::PeerStatus> peers_;
  mutable std::array<std::uint64_t, 2> limits_{consensus::kMaxPacketBytes,
                                               consensus::kMaxPacketBytes};
};

}  // namespace tandem::demos
