// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "acknowledger.h"
#include "channel_inbox.h"
#include "channel_wire.h"
#include "mtu_search.h"
#include "reliable_channel.h"
#include "sent_packets.h"
#include "state_queue.h"
#include "tandem/consensus/transport.h"

namespace tandem::net {

struct ChannelOptions {
  std::size_t state_queue_bytes = 64 * 1024;          ///< waiting; the oldest are dropped
  std::int64_t state_life = 200'000'000;              ///< ns; older ones are dropped
  std::size_t reliable_queue_bytes = 1024 * 1024;     ///< waiting or not acknowledged
  std::size_t max_message_bytes = 64 * 1024;          ///< of a reliable message
  std::size_t receive_queue_bytes = 4 * 1024 * 1024;  ///< of either kind, not drained
};

/// The two channels of one connection and their common acknowledgements: states, which may be lost,
/// and messages, which arrive in order and are sent in pieces. Packets in, packets out, without
/// sealing and sockets. Times in ns.
class Channels {
 public:
  /// @param max_datagram  upper limit of the path MTU search, bytes of UDP payload
  Channels(const ChannelOptions& options, std::size_t max_datagram);

  /// False if it does not fit into a packet of `room` plain bytes.
  bool post_state(std::span<const std::byte> state, std::size_t room, std::int64_t now);

  /// Path MTU.
  const MtuSearch& mtu() const { return mtu_; }
  /// Bytes of the probe to be sent; 0: none.
  std::size_t probe_due(std::int64_t now) { return mtu_.due(now); }
  /// The probe's plain bytes, in place of write(). @param datagram  probe_due()
  void write_probe(std::uint64_t sequence, std::size_t datagram, double kbit_per_s,
                   std::int64_t now, std::vector<std::byte>& out);
  bool post_reliable(std::span<const std::byte> message) { return reliable_.post(message); }
  /// Sent reliably, even if the queue is full.
  void post_group_change(std::span<const std::byte> change) {
    (void)reliable_.post(change, MessageKind::GroupChange);
  }
  /// Announce a third peer's address; may be lost.
  void tell(const KnownPeer& known) {
    if (to_tell_.size() < kMaxToTell) to_tell_.push_back(known);
  }

  /// Both directions of reliable messages. The next connection to the same process continues with
  /// them: nothing is lost or repeated.
  struct Reliable {
    ReliableSender sender;
    ReliableReceiver receiver;
  };
  Reliable take_reliable();
  void resume(Reliable reliable);
  /// Record a packet without any of these contents.
  void note_other(std::uint64_t sequence, std::int64_t now) { sent_.sent_empty(sequence, now); }

  /// Whether the next state fits into `room` plain bytes, or there is none.
  bool fits(std::size_t room) const { return states_.fits(room - kChannelHeader); }
  /// Whether anything but acknowledgements waits to be sent.
  bool has_content(std::int64_t now);
  /// Latest time of the next acknowledgement, INT64_MAX if none is due.
  std::int64_t ack_due() const { return acknowledger_.due(); }
  /// Appends a packet of at most `room` bytes to `out`: the acknowledgements, `clock` if given, and
  /// waiting contents that fit.
  void write(std::uint64_t sequence, std::size_t room, std::int64_t now, const ClockClaim* clock,
             std::vector<std::byte>& out);

  using Read = ChannelInbox::Read;
  Read read(std::uint64_t sequence, std::span<const std::byte> plain, std::int64_t now);
  /// Counts packets that were not acknowledged in time as lost.
  void on_time(std::int64_t now);

  using Message = ChannelInbox::Message;
  /// Received contents.
  ChannelInbox& inbox() { return inbox_; }
  const ChannelInbox& inbox() const { return inbox_; }

  /// Acknowledgements and losses since the last call.
  struct Feedback {
    std::uint64_t acked = 0;
    std::uint64_t acked_bytes = 0;  // on the wire
    std::uint64_t lost = 0;
    std::uint64_t late = 0;  // counted as lost before
  };
  Feedback take_feedback() { return std::exchange(feedback_, {}); }

  /// A clock exchange with the other end.
  struct Exchange {
    ClockSample sample;
    ClockClaim claim;
  };
  /// The latest one that was not taken.
  std::optional<Exchange> take_exchange() { return std::exchange(exchange_, {}); }

  /// Restart the round trip estimate on a new path.
  void begin_path();

  /// Highest packet known to be received; 0: none.
  std::uint64_t highest_acknowledged() const { return sent_.highest_acknowledged(); }
  std::int64_t first_sent_from(std::uint64_t sequence) const {
    return sent_.first_sent_from(sequence);
  }
  const RttEstimate& rtt() const { return sent_.rtt(); }
  const ReliableSender& reliable() const { return reliable_; }
  /// States posted and not sent, or received and not taken.
  std::uint64_t dropped_states() const { return states_.dropped() + inbox_.dropped_states(); }
  std::size_t waiting_states() const { return states_.size(); }

 private:
  void settle(std::int64_t now);
  bool write_piece(std::size_t end, std::vector<std::byte>& out);
  void note_clock(const ChannelSection& section, std::int64_t now);

  ChannelOptions options_;
  StateQueue states_;
  bool reliable_first_ = true;
  ReliableSender reliable_;
  std::vector<std::uint64_t> pieces_;  // of the packet being written
  std::deque<KnownPeer> to_tell_;
  std::size_t max_datagram_;
  MtuSearch mtu_;
  SentPackets sent_;
  SentPackets::Outcome outcome_;
  Feedback feedback_;

  ChannelPacket packet_;  // the packet being read
  Acknowledger acknowledger_;
  ChannelInbox inbox_;
  std::optional<Exchange> exchange_;
};

}  // namespace tandem::net
