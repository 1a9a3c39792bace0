// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "credentials.h"
#include "frame_queue.h"
#include "member_budget.h"
#include "outgoing_frames.h"
#include "places.h"
#include "tandem/net/clock.h"
#include "tandem/net/tcp.h"
#include "wire.h"

namespace tandem::net {

using SteadyTime = std::chrono::steady_clock::time_point;

inline std::int64_t nanoseconds(SteadyTime time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

/// State shared by the application's thread and the network thread: peers, their queues and
/// counters. One mutex, held for memory operations only. Without sockets: a connection is a serial
/// number ("link", never 0), and only the link attached to a peer may act for it.
class PeerTable {
 public:
  explicit PeerTable(const TcpOptions& options) : options_(options) {}

  // ---- application's thread ----

  struct PostResult {
    bool accepted = false;
    bool wake = false;           // the link was idle: wake the network thread
    std::uint64_t cut_link = 0;  // close this link: its queue has overflowed
  };
  PostResult post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery);
  void drain(std::vector<consensus::Packet>& out);
  /// The link to close, 0 if there is none.
  std::uint64_t drop(PeerId peer, const std::string& reason, SteadyTime now);
  std::vector<consensus::PeerStatus> peers() const;
  std::uint64_t incarnation(PeerId peer) const;

  // ---- network thread ----

  /// Why this peer is refused now; none if it is not.
  std::optional<std::string> refusal(const Hello& hello, const Member& member, SteadyTime now);
  /// Sequence number of the last Reliable frame received from that process of that peer.
  std::uint64_t received(PeerId peer, std::uint64_t incarnation, const Key& key) const;

  struct AttachResult {
    bool attached = false;
    std::uint64_t replaced_link = 0;  // close it: an older one, or of a peer that gives way
    std::string reason;               // why not attached, or why that one is closed
  };
  AttachResult attach(std::uint64_t link, const Hello& hello, const Member& member,
                      const Welcome& theirs, std::uint64_t ticket, SteadyTime now);
  /// The link has closed. Its peer is disconnected if the link is still the attached one.
  void detach(std::uint64_t link, PeerId peer, const std::string& reason);
  /// An unconnected peer could not be reached or was refused.
  void note_failure(PeerId peer, const std::string& reason, bool rejected);
  /// No longer a member: nothing of it or for it is kept.
  void expel(std::uint64_t link, PeerId peer, const std::string& reason);
  /// A protocol error: the peer is treated as after drop().
  void reject(std::uint64_t link, PeerId peer, const std::string& reason, SteadyTime now);

  enum class Delivered { Ok, Stale, Gap, Full, Abused };
  Delivered deliver(std::uint64_t link, PeerId peer, consensus::Delivery delivery,
                    std::uint64_t sequence, std::span<const std::byte> bytes, SteadyTime now);
  /// Count a frame other than the application's.
  void charge(std::uint64_t link, PeerId peer, SteadyTime now);
  /// Whether its budget allows reading more now.
  bool may_read(std::uint64_t link, PeerId peer, SteadyTime now);
  /// False if that number was never sent.
  bool acknowledge(std::uint64_t link, PeerId peer, std::uint64_t sequence);
  /// Appends queued frames to `out`, oldest first, until it holds about `limit` bytes.
  void take(std::uint64_t link, PeerId peer, std::size_t limit, std::vector<std::byte>& out);
  /// 0 if it is not connected.
  std::uint64_t link_of(PeerId peer) const;
  /// Whether to dial it: neither connected nor dropped.
  bool wanted(PeerId peer) const;
  /// From here on only Reliable frames are sent.
  void begin_shutdown();

 private:
  struct Record {
    consensus::PeerStatus status;
    std::uint64_t incarnation = 0;
    Member member;  ///< present or last user of this id
    Seniority seniority;
    SteadyTime since{};  ///< of the attached link
    std::uint64_t link = 0;
    std::uint64_t ticket = 0;
    std::size_t max_payload = 0;  // the smaller one of both limits
    OutgoingFrames outgoing;
    std::uint64_t last_received = 0;
    FrameQueue inbox;
    MemberBudget budget;  // of the attached link
    bool wake_posted = false;
    bool dropped = false;         // until its next handshake
    std::uint64_t departure = 0;  // order of disconnections; 0 = never connected
    SteadyTime hold_until{};
  };

  Record* find(PeerId peer);
  const Record* find(PeerId peer) const;
  Record* find_attached(std::uint64_t link, PeerId peer);
  Record* find_or_add(PeerId peer);
  bool make_room();
  std::optional<std::string> refusal_locked(const Hello& hello, const Member& member,
                                            SteadyTime now);
  void disconnect(Record& record, const std::string& reason);
  /// See who_gives_way().
  Record* guest_in_place_of(PeerId peer, const Member& member);
  void ban(Record& record, const std::string& reason, SteadyTime now);

  const TcpOptions options_;
  mutable std::mutex mutex_;
  std::map<PeerId, Record> records_;  // by id: the order of drain and peers
  std::size_t connected_ = 0;
  std::uint64_t arrivals_ = 0;
  std::uint64_t departures_ = 0;
  bool shutting_down_ = false;
  SessionClock clock_;  ///< dates incoming packets
};

}  // namespace tandem::net
