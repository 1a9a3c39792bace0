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

/// Calls of a transport in one phase, each kind counted by itself: so an answer finds its call
/// again even where a changed program makes other calls between.
struct TransportCalls {
  std::uint64_t drains = 0;
  std::uint64_t looks = 0;  ///< of peers()
  std::uint64_t posts = 0;
  std::array<std::uint64_t, 2> limits{};  ///< of max_packet_bytes(), by delivery
};

/// Whether two lists of peers are the same as far as traces have them.
bool same_in_trace(std::span<const consensus::PeerStatus> a,
                   std::span<const consensus::PeerStatus> b);

/// Where a TracingTransport puts what it hears.
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  /// `call` is of the phase. May throw nothing.
  virtual void packets(std::uint64_t call, std::span<const consensus::Packet> packets) = 0;
  virtual void answer(const TraceRecord& record) = 0;
};

/// Passes everything on, and writes down each answer that is not what the reader of a trace takes
/// for granted: nothing came, posts are taken, all else is as before.
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
  // What is asked changes nothing but what is remembered of it.
  mutable TransportCalls calls_;
  mutable TraceRecord answer_;
  mutable std::vector<consensus::PeerStatus> peers_;
  mutable std::array<std::uint64_t, 2> limits_{};
};

/// Answers as a trace has it. Counts of packets and bytes and reasons are not in a trace: zero and
/// empty here.
/// @par Thread safety  One object: one thread at a time.
class ReplayTransport final : public consensus::Transport {
 public:
  explicit ReplayTransport(consensus::PeerId self) : self_(self) {}

  /// The answers of the phase to come; must outlive it.
  void begin_phase(std::span<const TraceRecord> answers);
  /// Whether packets of the phase were never asked for.
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
