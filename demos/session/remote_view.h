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

/// What a process can know of its peers' worlds: the states that they send, at their own stamps,
/// and which bodies their users hold. A peer that is never heard has no record.
class RemoteView {
 public:
  explicit RemoteView(const Scene& scene);

  /// Look at a packet. What does not decode is passed over: refusing it is the session's business.
  /// @param arrival  given: stamps are read by it, as with consensus::TimestampSource::Arrival
  void look(consensus::PeerId from, std::span<const std::byte> packet,
            const std::optional<consensus::Arrival>& arrival = {});
  /// The peer's process is gone: its users hold nothing more.
  void forget_hands(consensus::PeerId peer);
  /// Keep nothing: for sessions without an end.
  void record_nothing() { recording_ = false; }
  /// By ascending id.
  std::vector<PeerRecord> records() const;

 private:
  /// Of a peer: hands beyond these are not looked at, so that nobody fills our memory.
  static constexpr std::size_t kMaxSprings = 256;
  struct Hand {
    std::size_t body = 0;
    std::uint32_t revision = 0;
    bool released = false;  ///< remembered: what was under way meanwhile revives nothing
  };
  struct Remote {
    std::vector<Track> tracks;
    std::map<std::uint32_t, Hand> springs;  ///< by their numbers
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
