// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "scenes/scene.h"
#include "session/track.h"
#include "tandem/consensus/sender_clocks.h"
#include "tandem/consensus/update.h"

namespace tandem::demos {

/// The other peers' worlds as they send them, at their own stamps, and the bodies that their users
/// hold. A silent peer has no record.
class RemoteView {
 public:
  explicit RemoteView(const Scene& scene);

  /// Reads a packet. Invalid packets are skipped: the session refuses them.
  /// @param arrival  if given, stamps are replaced as with consensus::TimestampSource::Arrival
  void look(consensus::PeerId from, std::span<const std::byte> packet,
            const std::optional<consensus::Arrival>& arrival = {});
  /// The peer's process is gone: its users release everything.
  void forget_hands(consensus::PeerId peer);
  /// Keeps nothing: for endless sessions.
  void record_nothing() { recording_ = false; }
  /// By ascending id.
  std::vector<PeerRecord> records() const;

 private:
  /// Per peer: further springs are ignored, to bound memory.
  static constexpr std::size_t kMaxSprings = 256;
  struct Hand {
    std::size_t body = 0;
    std::uint32_t revision = 0;
    bool released = false;  ///< kept, so that a late packet does not revive it
  };
  struct Remote {
    std::vector<Track> tracks;
    std::map<std::uint32_t, Hand> springs;  ///< by number
  };
  void look(Remote& remote, const consensus::SpringUpdate& spring) const;
  bool body_index(const consensus::SharedId& id, std::size_t& index) const;

  std::map<consensus::SharedId, std::size_t> index_;
  std::map<consensus::PeerId, Remote> remotes_;
  consensus::DecodedPacket decoded_;
  bool recording_ = true;
  consensus::SenderClocks clocks_;
};

}  // namespace tandem::demos
