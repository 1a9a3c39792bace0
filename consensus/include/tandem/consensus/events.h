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

/// An application event: a door was unlocked, a round is over.
struct TANDEM_API Event {
  PeerId from = 0;
  Role role = Role::Share;  ///< of its sender, as the transport knows it
  SessionTime stamp = 0;    ///< ns, when it was sent
  std::string topic = {};   ///< untrusted, like the payload
  std::vector<std::byte> payload = {};
};

struct TANDEM_API EventOptions {
  /// Bytes of events kept for one peer until it acknowledges them. Beyond that the oldest are
  /// dropped and counted by EventChannel::lost().
  std::size_t kept_bytes = std::size_t{1} << 20;
  /// Bytes of events per second accepted from one peer; the rest waits at the sender.
  double bytes_per_s = 256.0 * 1024.0;
  /// s: an event not acknowledged for this long is sent again.
  double resend = 0.5;
  /// s: a peer absent for longer loses the events that waited for it, and gets those sent after its
  /// return.
  double absence = 60.0;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Messages of the application between the peers of a session, by topic. Each arrives once, and
/// those of one sender arrive in the order sent, whatever the network loses, repeats or interrupts
/// ([friston] Sec. 7.11). A peer that joins later receives only what is sent from then on.
///
/// It wraps the transport, and the peer uses it as its transport:
///
///     EventChannel channel(transport);
///     Peer peer(world, channel);
///     channel.poll(now);  // before each Peer::before_step(now)
///     for (const Event& event : channel.received()) ...
///
/// All members of a session use an EventChannel, or none does. Other peers are untrusted: what they
/// send is decoded, counted and dropped, and cannot use more memory than the options allow.
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

  /// Send an event, stamped with the time of the last poll(), to one peer or to all that are
  /// connected or have not been absent for longer than EventOptions::absence. It leaves with the
  /// next poll().
  /// @return number of receivers
  /// @throws std::invalid_argument naming topic or payload if they are too long for a packet of the
  /// transport
  std::size_t send(std::string_view topic, std::span<const std::byte> payload, PeerId to = kToAll);
  /// Call before each step, at session time `now` in ns: receives events and sends those that are
  /// due.
  void poll(SessionTime now);
  /// Events received by the last poll(), those of each sender in the order sent. Valid until the
  /// next poll().
  std::span<const Event> received() const;

  /// Events dropped because too many waited for a peer, and events of others that this peer missed.
  std::uint64_t lost() const;
  /// Event packets that could not be decoded.
  std::uint64_t rejected() const;

  PeerId self() const override;
  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override;
  std::size_t max_packet_bytes(Delivery delivery) const override;
  /// All packets but those of events.
  void drain(std::vector<Packet>& out) override;
  void drop(PeerId peer, const std::string& reason) override;
  std::vector<PeerStatus> peers() const override;
  void list_peers(std::vector<PeerStatus>& out) const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::consensus
