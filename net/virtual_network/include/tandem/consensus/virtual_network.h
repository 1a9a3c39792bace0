// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// One direction of a link between two peers.
struct TANDEM_API LinkOptions {
  double latency = 0.0;    ///< s, one way, mean
  double jitter = 0.0;     ///< s, one way: delay is uniform in latency +- jitter, never below 0
  double loss = 0.0;       ///< probability that a packet is lost, 0 to 0.99
  double duplicate = 0.0;  ///< probability that a state arrives twice, 0 to 1
  double reorder = 0.0;    ///< probability that later states overtake one
  double reorder_delay = 0.02;          ///< s, longest time that it is held back; uniform from 0
  double bandwidth = 0.0;               ///< bit/s of payload; 0 = unlimited
  double bursts = 0.0;                  ///< bursts of loss, 1/s: every packet is lost
  double burst_length = 0.2;            ///< s, mean; from 0 to twice that
  double stalls = 0.0;                  ///< 1/s: packets leave at the end, all at once
  double stall_length = 1.0;            ///< s, mean; from 0 to twice that
  std::size_t queue_limit = 64 * 1024;  ///< bytes that may wait for the bandwidth
  /// Bytes of the longest state; longer ones are refused, as over UDP with a small MTU (502 at an
  /// MTU of 576, see docs/protocol.md). Reliable packets are split there.
  std::size_t max_state_bytes = 64 * 1024;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// One direction of the network profiles of [friston] Table 3, 1 (dedicated fibre) to 5
/// (intercontinental): latency 3.5, 6, 28.5, 63.5, 123.5 ms; one-way jitter 0, 0.5, 2.5, 4, 5 ms.
/// The paper's links ran TCP: no loss.
/// @throws std::invalid_argument for other numbers
TANDEM_API LinkOptions network_profile(int number);

/// A network as people have it at home or travelling, as seen by its user.
struct TANDEM_API NamedNetwork {
  std::string_view name = {};
  LinkOptions up = {};    ///< from the user to the others
  LinkOptions down = {};  ///< from the others to the user
};
/// wifi: stalls of up to 2 s. swollen: a buffer that fills to 1 s if more than 128 kbit/s are sent.
/// lopsided: 200 ms there and 20 ms back. bursts: 5 % lost, in bursts.
TANDEM_API std::span<const NamedNetwork> named_networks();

/// Fate of the packets of one direction.
struct TANDEM_API LinkCounters {
  std::uint64_t posted = 0;      ///< accepted from the sender
  std::uint64_t delivered = 0;   ///< copies that arrived
  std::uint64_t lost = 0;        ///< states lost in transit, bursts included
  std::uint64_t duplicated = 0;  ///< second copies
  std::uint64_t held_back = 0;   ///< states delayed to be overtaken
  std::uint64_t resent = 0;      ///< losses of reliable packets, resent
  std::uint64_t queue_full = 0;  ///< states dropped for lack of bandwidth
  std::uint64_t cut = 0;         ///< states dropped because the link was cut
};

/// Any number of peers in one process, in virtual time: all events happen in advance_to().
///
/// - Delivery::Newest may be lost, doubled or held back; jitter reorders packets sent at shorter
/// intervals. A full queue drops the oldest waiting state.
/// - Delivery::Reliable is never lost: each loss costs a resend after twice the latency (at least 1
/// ms), and later reliable packets wait for it. post() refuses it if kMaxReliableBytes wait.
/// - In a burst all packets sent are lost; reliable ones are resent after its end.
/// - Transport::max_packet_bytes() is the minimum over all outgoing links.
/// - While a link is cut, states are dropped and reliable packets wait for heal(). Both sides see a
///   link that is cut in either direction as not connected.
/// - Transport::drop() closes both directions for good until heal(), the new handshake.
/// - Received packets wait for drain() without a limit. PeerStatus::round_trip is smoothed, over
/// states in both directions, and known once one has arrived in each.
///
/// The same seed and calls give the same deliveries, bit for bit on every machine, however the time
/// is divided into calls of advance_to(). Each direction has its own generator.
/// @par Thread safety  Distinct networks: safe. One network with all its transports: one thread.
class TANDEM_API VirtualNetwork {
 public:
  static constexpr std::size_t kMaxPacketBytes = 64 * 1024;      ///< longer ones are refused
  static constexpr std::size_t kMaxReliableBytes = 1024 * 1024;  ///< waiting in one direction

  /// @param options  for every direction without a set_link()
  /// @param start  session time to begin at, ns
  /// @throws std::invalid_argument if the options are not valid
  explicit VirtualNetwork(const LinkOptions& options = {}, std::uint64_t seed = 1,
                          SessionTime start = 0);
  ~VirtualNetwork();
  VirtualNetwork(const VirtualNetwork&) = delete;
  VirtualNetwork& operator=(const VirtualNetwork&) = delete;

  /// The transport of a peer, which joins at the first call. Valid as long as the network.
  /// @throws std::invalid_argument for peer 0
  Transport& transport(PeerId peer);

  /// Change one direction, for packets sent from now on.
  /// @throws std::invalid_argument if the options are not valid or a peer has not joined
  void set_link(PeerId from, PeerId to, const LinkOptions& options);
  /// Cut one direction. States in transit are lost. @throws as set_link
  void cut(PeerId from, PeerId to);
  /// Restore one direction, after cut() or drop(). @throws as set_link
  void heal(PeerId from, PeerId to);

  SessionTime now() const;
  /// Deliver everything that is due up to `time`, ns.
  /// @throws std::invalid_argument if `time` is before now()
  void advance_to(SessionTime time);
  /// No delivery happens before this time; nullopt if nothing is in transit.
  std::optional<SessionTime> next_event() const;

  /// Reading of a peer's clock, for Packet::received: `ahead` ns beyond now() at the network's
  /// start, and drifting by so many ppm since. By default all show now().
  /// @throws std::invalid_argument if the peer has not joined, |ahead| > 1e18 ns or |drift| > 1000
  void set_clock(PeerId peer, SessionTime ahead, double drift_ppm = 0.0);

  /// @throws as set_link
  LinkCounters counters(PeerId from, PeerId to) const;

 private:
  struct State;
  class Endpoint;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::consensus
