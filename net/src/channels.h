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
  std::size_t state_queue_bytes = 64 * 1024;          ///< waiting to be sent; the oldest go first
  std::int64_t state_life = 200'000'000;              ///< ns; older ones are not sent any more
  std::size_t reliable_queue_bytes = 1024 * 1024;     ///< waiting or not acknowledged
  std::size_t max_message_bytes = 64 * 1024;          ///< of a reliable message
  std::size_t receive_queue_bytes = 4 * 1024 * 1024;  ///< of either kind, not drained
};

/// The two channels of one connection and the acknowledgements that both of them need: states that
/// may be lost, and messages that come in order, cut into pieces. Packets in, packets out; sealing
/// and sending is someone else's. Times in ns.
class Channels {
 public:
  /// @param max_datagram  the most that is tried, bytes of UDP payload
  Channels(const ChannelOptions& options, std::size_t max_datagram);

  /// False where it does not fit into a packet of `room` plain bytes.
  bool post_state(std::span<const std::byte> state, std::size_t room, std::int64_t now);

  /// How long datagrams may be on the way there.
  const MtuSearch& mtu() const { return mtu_; }
  /// Bytes of a datagram that is to be sent to find that out; 0: none.
  std::size_t probe_due(std::int64_t now) { return mtu_.due(now); }
  /// The plain bytes of it, in place of write(). @param datagram  probe_due()
  void write_probe(std::uint64_t sequence, std::size_t datagram, double kbit_per_s,
                   std::int64_t now, std::vector<std::byte>& out);
  bool post_reliable(std::span<const std::byte> message) { return reliable_.post(message); }
  /// Reliably, and whatever else waits.
  void post_group_change(std::span<const std::byte> change) {
    (void)reliable_.post(change, MessageKind::GroupChange);
  }
  /// Tell the other end where a third peer is; may be lost.
  void tell(const KnownPeer& known) {
    if (to_tell_.size() < kMaxToTell) to_tell_.push_back(known);
  }

  /// Both directions of reliable messages. The next connection to the same process goes on with
  /// them: nothing is lost, nothing comes twice.
  struct Reliable {
    ReliableSender sender;
    ReliableReceiver receiver;
  };
  Reliable take_reliable();
  void resume(Reliable reliable);
  /// A packet that carries none of this.
  void note_other(std::uint64_t sequence, std::int64_t now) { sent_.sent_empty(sequence, now); }

  /// The next state is small enough for `room` plain bytes, or there is none.
  bool fits(std::size_t room) const { return states_.fits(room - kChannelHeader); }
  /// Something waits to be sent; acknowledgements alone do not count.
  bool has_content(std::int64_t now);
  /// When an acknowledgement has to leave at the latest, INT64_MAX where none is due.
  std::int64_t ack_due() const { return acknowledger_.due(); }
  /// Appends a packet of at most `room` bytes to `out`: the acknowledgements, `clock` where there
  /// is one, and what waits and fits.
  void write(std::uint64_t sequence, std::size_t room, std::int64_t now, const ClockClaim* clock,
             std::vector<std::byte>& out);

  using Read = ChannelInbox::Read;
  Read read(std::uint64_t sequence, std::span<const std::byte> plain, std::int64_t now);
  /// What has not been acknowledged in time is lost.
  void on_time(std::int64_t now);

  using Message = ChannelInbox::Message;
  /// What has come.
  ChannelInbox& inbox() { return inbox_; }
  const ChannelInbox& inbox() const { return inbox_; }

  /// What has become of packets since the last call.
  struct Feedback {
    std::uint64_t acked = 0;
    std::uint64_t acked_bytes = 0;  // on the wire
    std::uint64_t lost = 0;
    std::uint64_t late = 0;  // were counted as lost and have come
  };
  Feedback take_feedback() { return std::exchange(feedback_, {}); }

  /// What the other end has said of its clock.
  struct Exchange {
    ClockSample sample;
    ClockClaim claim;
  };
  /// The latest that has not been taken.
  std::optional<Exchange> take_exchange() { return std::exchange(exchange_, {}); }

  /// Round trips of before were those of another way.
  void begin_path();

  /// Of all packets that were sent the last that is known to have come; 0: none.
  std::uint64_t highest_acknowledged() const { return sent_.highest_acknowledged(); }
  std::int64_t first_sent_from(std::uint64_t sequence) const {
    return sent_.first_sent_from(sequence);
  }
  const RttEstimate& rtt() const { return sent_.rtt(); }
  const ReliableSender& reliable() const { return reliable_; }
  /// Posted and not sent, or come and not taken.
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
  std::vector<std::uint64_t> pieces_;  // of the packet that is being written
  std::deque<KnownPeer> to_tell_;
  std::size_t max_datagram_;
  MtuSearch mtu_;
  SentPackets sent_;
  SentPackets::Outcome outcome_;
  Feedback feedback_;

  ChannelPacket packet_;  // that is being read
  Acknowledger acknowledger_;
  ChannelInbox inbox_;
  std::optional<Exchange> exchange_;
};

}  // namespace tandem::net
