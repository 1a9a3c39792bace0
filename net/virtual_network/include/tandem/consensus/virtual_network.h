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
  double loss = 0.0;       ///< chance that a packet is lost, 0 to 0.99
  double duplicate = 0.0;  ///< chance that a state comes twice, 0 to 1
  double reorder = 0.0;    ///< chance that a state is held back, so that later ones overtake it
  double reorder_delay = 0.02;          ///< s, longest time it is held back; uniform from 0
  double bandwidth = 0.0;               ///< bit/s of payload; 0 = unlimited
  double bursts = 0.0;                  ///< bursts of loss, 1/s: nothing gets through
  double burst_length = 0.2;            ///< s, mean; from 0 to twice that
  double stalls = 0.0;                  ///< 1/s: what leaves then leaves at the end, all at once
  double stall_length = 1.0;            ///< s, mean; from 0 to twice that
  std::size_t queue_limit = 64 * 1024;  ///< bytes that may wait for the bandwidth
  /// Bytes of the longest state; longer ones are refused, as over UDP with a small MTU (502 at an
  /// MTU of 576, see docs/protocol.md). Reliable packets are cut into pieces there.
  std::size_t max_state_bytes = 64 * 1024;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// One direction of the network profiles of [friston] Table 3, 1 (dedicated fibre) to 5
/// (intercontinental): latency 3.5, 6, 28.5, 63.5, 123.5 ms; one-way jitter 0, 0.5, 2.5, 4, 5 ms.
/// The paper's links ran TCP: no loss.
/// @throws std::invalid_argument for other numbers
TANDEM_API LinkOptions network_profile(int number);

/// A network as people have them at home and on the way, as its user sees it.
struct TANDEM_API NamedNetwork {
  std::string_view name = {};
  LinkOptions up = {};    ///< from him to the others
  LinkOptions down = {};  ///< from the others to him
};
/// wifi: stalls of up to 2 s. swollen: a buffer that fills to 1 s where more than 128 kbit/s are
/// sent. lopsided: 200 ms there and 20 ms back. bursts: 5 % lost, in bursts.
TANDEM_API std::span<const NamedNetwork> named_networks();

/// What became of the packets of one direction.
struct TANDEM_API LinkCounters {
  std::uint64_t posted = 0;      ///< accepted from the sender
  std::uint64_t delivered = 0;   ///< copies that reached the receiver
  std::uint64_t lost = 0;        ///< states lost on the way, in bursts as well
  std::uint64_t duplicated = 0;  ///< second copies
  std::uint64_t held_back = 0;   ///< states delayed to be overtaken
  std::uint64_t resent = 0;      ///< losses of reliable packets, made good
  std::uint64_t queue_full = 0;  ///< states dropped for want of bandwidth
  std::uint64_t cut = 0;         ///< states dropped because the link was cut
};

/// Any number of peers in one process, in virtual time: nothing happens but in advance_to().
///
/// - Delivery::Newest may be lost, doubled, held back; jitter alone reorders packets that are sent
///   closer together than it. A full queue drops the oldest waiting state.
/// - Delivery::Reliable is never lost: each loss costs a resend after twice the latency (1 ms at
///   least), and later reliable packets wait for it. post() refuses it where kMaxReliableBytes
///   wait.
/// - In a burst all that leaves is lost; reliable packets are resent after its end.
/// - Transport::max_packet_bytes() is the least of all links that go out.
/// - While a link is cut, states are dropped and reliable packets wait for heal(). Both sides see a
///   link that is cut in either direction as not connected.
/// - Transport::drop() closes both directions for good until heal(), the new handshake.
/// - What has arrived waits for drain() without a limit. PeerStatus::round_trip is smoothed, of
///   states in both directions, and known once one has come in each.
///
/// Same seed and same calls, same deliveries, bit for bit on every machine, and however the time is
/// cut into calls of advance_to(). Each direction draws from a generator of its own.
/// @par Thread safety  Distinct networks: safe. One network with all its transports: one thread.
class TANDEM_API VirtualNetwork {
 public:
  static constexpr std::size_t kMaxPacketBytes = 64 * 1024;      ///< longer ones are refused
  static constexpr std::size_t kMaxReliableBytes = 1024 * 1024;  ///< waiting on one direction

  /// @param options  of every direction that set_link() does not name
  /// @param start  session time to begin at, ns
  /// @throws std::invalid_argument where the options are not valid
  explicit VirtualNetwork(const LinkOptions& options = {}, std::uint64_t seed = 1,
                          SessionTime start = 0);
  ~VirtualNetwork();
  VirtualNetwork(const VirtualNetwork&) = delete;
  VirtualNetwork& operator=(const VirtualNetwork&) = delete;

  /// The transport of a peer, which joins at the first call. Valid as long as the network.
  /// @throws std::invalid_argument for peer 0
  Transport& transport(PeerId peer);

  /// Change one direction for packets that are sent from now on.
  /// @throws std::invalid_argument where the options are not valid or a peer has not joined
  void set_link(PeerId from, PeerId to, const LinkOptions& options);
  /// Cut one direction. States on the way are lost. @throws as set_link
  void cut(PeerId from, PeerId to);
  /// Mend one direction, after cut() or drop(). @throws as set_link
  void heal(PeerId from, PeerId to);

  SessionTime now() const;
  /// Deliver everything that is due up to `time`, ns.
  /// @throws std::invalid_argument where `time` is before now()
  void advance_to(SessionTime time);
  /// No delivery happens before this time; nullopt where nothing is on its way.
  std::optional<SessionTime> next_event() const;

  /// What a peer's clock shows, for Packet::received: `ahead` ns beyond now() at the network's
  /// start, and so many millionths more since. By default all show now().
  /// @throws std::invalid_argument where the peer has not joined, |ahead| > 1e18 ns or |drift| >
  /// 1000
  void set_clock(PeerId peer, SessionTime ahead, double drift_ppm = 0.0);

  /// @throws as set_link
  LinkCounters counters(PeerId from, PeerId to) const;

 private:
  struct State;
  class Endpoint;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::consensus
