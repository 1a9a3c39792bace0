// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Something that happened, in the application's own words: a door was unlocked, a round is over.
struct TANDEM_API Event {
  PeerId from = 0;
  Role role = Role::Share;  ///< of its sender, as the transport knows it
  SessionTime stamp = 0;    ///< ns, when it was sent
  std::string topic = {};   ///< untrusted, as the payload is
  std::vector<std::byte> payload = {};
};

struct TANDEM_API EventOptions {
  /// Bytes of events that are kept for one other peer until it has them. Beyond that the oldest go,
  /// and EventChannel::lost() counts them.
  std::size_t kept_bytes = std::size_t{1} << 20;
  /// Bytes of events a second that are taken from one other peer; the rest waits at its side.
  double bytes_per_s = 256.0 * 1024.0;
  /// s: what was not acknowledged is sent again after that.
  double resend = 0.5;
  /// s: who is away for so long gets what is sent once he is back, and nothing that was before.
  double absence = 60.0;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Messages of the application between the peers of a session, by topic: each comes once, and those
/// of one sender in the order in which they were sent, whatever the network loses, repeats or cuts
/// off for a while ([friston] Sec. 7.11). Who joins later hears what is sent from then on.
///
/// It stands between a peer and its transport, with which it shares the way:
///
///     EventChannel channel(transport);
///     Peer peer(world, channel);
///     channel.poll(now);  // before each Peer::before_step(now)
///     for (const Event& event : channel.received()) ...
///
/// All members of a session use one, or none does. The other peers count as one that may lie: what
/// it sends is decoded, counted and dropped; it can fill no more memory than the options say.
/// @par Thread safety  As Transport.
class TANDEM_API EventChannel final : public Transport {
 public:
  static constexpr std::size_t kMaxTopicBytes = 64;
  static constexpr PeerId kToAll = 0;

  /// The transport must outlive it. @throws std::invalid_argument (EventOptions::validate)
  explicit EventChannel(Transport& transport, const EventOptions& options = {});
  ~EventChannel() override;
  EventChannel(const EventChannel&) = delete;
  EventChannel& operator=(const EventChannel&) = delete;

  /// Send an event with the time of the last poll(), to one peer or to all that are there, or
  /// have not been away for longer than EventOptions::absence. It leaves with the next poll().
  /// @return to how many
  /// @throws std::invalid_argument naming topic or payload where they are too long for a packet of
  ///   the transport
  std::size_t send(std::string_view topic, std::span<const std::byte> payload, PeerId to = kToAll);
  /// Once before each step, at session time `now` in ns: take in what has come, send what is due.
  void poll(SessionTime now);
  /// What the last poll() took in: of each sender in the order in which it was sent. Valid until
  /// the next one.
  std::span<const Event> received() const;

  /// Events that a peer did not get since too much waited for it, and that this one did not get.
  std::uint64_t lost() const;
  /// Packets that could not be read.
  std::uint64_t rejected() const;

  PeerId self() const override;
  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override;
  std::size_t max_packet_bytes(Delivery delivery) const override;
  /// All but events.
  void drain(std::vector<Packet>& out) override;
  void drop(PeerId peer, const std::string& reason) override;
  std::vector<PeerStatus> peers() const override;
  void list_peers(std::vector<PeerStatus>& out) const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::consensus
