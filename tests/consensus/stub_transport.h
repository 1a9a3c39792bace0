// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"

namespace tandem::consensus::testing {

/// Delivers what the test puts into `inbox`, and notes what is posted and who is dropped.
class StubTransport : public Transport {
 public:
  explicit StubTransport(PeerId self) : self_(self) {}

  std::vector<Packet> inbox;
  std::vector<std::vector<std::byte>> posted;
  std::vector<std::pair<PeerId, std::string>> dropped;
  std::vector<PeerStatus> known;

  template <class Record>
  void deliver(PeerId from, const Record& record) {
    inbox.push_back({from, packet_of(record)});
  }
  template <class Record>
  static std::vector<std::byte> packet_of(const Record& record) {
    std::vector<std::byte> bytes;
    if constexpr (std::is_same_v<Record, Leave>) {
      encode(record, bytes);
    } else {
      encode(std::span<const Record>(&record, 1), bytes);
    }
    return bytes;
  }

  PeerId self() const override { return self_; }
  bool post(PeerId, std::span<const std::byte> bytes, Delivery) override {
    posted.emplace_back(bytes.begin(), bytes.end());
    return true;
  }
  void drain(std::vector<Packet>& out) override {
    out.insert(out.end(), inbox.begin(), inbox.end());
    inbox.clear();
  }
  void drop(PeerId peer, const std::string& reason) override { dropped.emplace_back(peer, reason); }
  std::vector<PeerStatus> peers() const override { return known; }

 private:
  PeerId self_;
};

/// Packets of one peer's drains, one entry per drain.
using Recording = std::vector<std::vector<Packet>>;

/// Passes everything on to another transport and keeps what it drained.
class RecordingTransport final : public Transport {
 public:
  explicit RecordingTransport(Transport& below) : below_(below) {}
  Recording recording;

  PeerId self() const override { return below_.self(); }
  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override {
    return below_.post(to, bytes, delivery);
  }
  std::size_t max_packet_bytes(Delivery delivery) const override {
    return below_.max_packet_bytes(delivery);
  }
  void drain(std::vector<Packet>& out) override {
    const std::size_t before = out.size();
    below_.drain(out);
    recording.emplace_back(out.begin() + static_cast<std::ptrdiff_t>(before), out.end());
  }
  void drop(PeerId peer, const std::string& reason) override { below_.drop(peer, reason); }
  std::vector<PeerStatus> peers() const override { return below_.peers(); }

 private:
  Transport& below_;
};

}  // namespace tandem::consensus::testing
