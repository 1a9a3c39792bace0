// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"

namespace tandem::demos {

/// Cuts packets of states and springs that are too long for one datagram into several that are not,
/// for transports that refuse them.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class SplitStates final : public consensus::Transport {
 public:
  /// @param inner  must outlive it     @param most  bytes of the longest state that it takes
  SplitStates(consensus::Transport& inner, std::size_t most) : inner_(inner), most_(most) {}

  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  void drain(std::vector<consensus::Packet>& out) override { inner_.drain(out); }
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 private:
  template <class Record>
  bool post_records(consensus::PeerId to, std::span<const Record> records, std::size_t each);

  consensus::Transport& inner_;
  std::size_t most_;
  consensus::DecodedPacket decoded_;
  std::vector<std::byte> part_;
};

}  // namespace tandem::demos
