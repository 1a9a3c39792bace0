// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/room_transport.h"

#include <sodium.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

namespace tandem::room {

namespace {

constexpr std::size_t kPacketBytes = 1100;  // must not be fragmented, see pages
constexpr int kFirstQuestions = 5;          // for the time, in direct succession
constexpr std::int64_t kAskAgain = 200'000'000;
constexpr std::int64_t kAskLater = 10'000'000'000;

std::int64_t steady() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void random_bytes(std::span<std::uint8_t> bytes) { randombytes_buf(bytes.data(), bytes.size()); }

}  // namespace

RoomTransport::RoomTransport(const Address& address, MemberId self, std::string profile)
    : self_(self),
      profile_(std::move(profile)),
      cipher_(address.key, address.room, self, random_bytes),
      link_(address, self) {}

bool RoomTransport::send(MemberId to, Channel channel, std::span<const std::uint8_t> bytes) {
  plain_.assign(1, static_cast<std::uint8_t>(channel));
  plain_.insert(plain_.end(), bytes.begin(), bytes.end());
  if (!cipher_.seal(to, plain_, sealed_)) return false;
  const bool newest = channel != Channel::Reliable && channel != Channel::Words;
  Bytes out = message(newest ? Wire::Newest : Wire::Reliable, to);
  out.insert(out.end(), sealed_.begin(), sealed_.end());
  return link_.send(std::move(out));
}

bool RoomTransport::post(consensus::PeerId to, std::span<const std::byte> bytes,
                         consensus::Delivery delivery) {
  const auto found = members_.find(to);
  if (found == members_.end() || !found->second.here || found->second.away) return false;
  const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return send(to, delivery == consensus::Delivery::Newest ? Channel::Newest : Channel::Reliable,
              {first, bytes.size()});
}

std::size_t RoomTransport::max_packet_bytes(consensus::Delivery /*delivery*/) const {
  return kPacketBytes;
}

void RoomTransport::drain(std::vector<consensus::Packet>& out) {
  std::move(packets_.begin(), packets_.end(), std::back_inserter(out));
  packets_.clear();
}

void RoomTransport::drop(consensus::PeerId peer, const std::string& reason) {
  const auto found = members_.find(peer);
  if (found == members_.end()) return;
  found->second.here = false;
  found->second.dropped = true;
  found->second.reason = reason;
}

std::vector<consensus::PeerStatus> RoomTransport::peers() const {
  std::vector<consensus::PeerStatus> all;
  for (const auto& [id, member] : members_) {
    consensus::PeerStatus status;
    status.id = id;
    status.connected = member.here && !member.away && link_.connected();
    status.reason = member.reason;
    all.push_back(std::move(status));
  }
  return all;
}

std::size_t RoomTransport::members() const {
  return static_cast<std::size_t>(std::count_if(
      members_.begin(), members_.end(), [](const auto& entry) { return entry.second.here; }));
}

void RoomTransport::set_away(MemberId id, bool away) {
  const auto found = members_.find(id);
  if (found != members_.end()) found->second.away = away;
}

void RoomTransport::take(std::vector<Heard>& out) {
  std::move(heard_.begin(), heard_.end(), std::back_inserter(out));
  heard_.clear();
}

void RoomTransport::take_newcomers(std::vector<MemberId>& out) {
  out.insert(out.end(), newcomers_.begin(), newcomers_.end());
  newcomers_.clear();
}

std::optional<consensus::SessionTime> RoomTransport::now() const {
  if (!offset_) return std::nullopt;
  return steady() + *offset_;
}

void RoomTransport::poll() {
  taken_.clear();
  link_.take(taken_);
  for (const Bytes& message : taken_) hear(message);
  const std::int64_t now = steady();
  if (now - asked_ > (questions_ < kFirstQuestions ? kAskAgain : kAskLater) && link_.connected()) {
    asked_ = now;
    link_.send(message(Wire::Time, static_cast<std::uint64_t>(now)));
  }
}

void RoomTransport::hear(const Bytes& message) {
  if (message.empty()) {  // a new connection
    asked_ = INT64_MIN / 2;
    questions_ = 0;
    for (auto& [id, member] : members_) member.here = false;
    return;
  }
  const auto kind = static_cast<Wire>(message[0]);
  const std::span<const std::uint8_t> rest = std::span(message).subspan(1);
  if (kind == Wire::Welcome) {
    for (std::size_t at = 0; at + 8 <= rest.size(); at += 8) greet(read_u64(rest, at));
    return;
  }
  if (rest.size() < 8) return;
  const MemberId id = read_u64(rest, 0);
  switch (kind) {
    case Wire::Newest:
    case Wire::Reliable:
      return open(id, rest.subspan(8));
    case Wire::Came:
      return greet(id);
    case Wire::Gone:
      if (const auto found = members_.find(id); found != members_.end()) {
        found->second.here = false;
        found->second.reason = "has left";
      }
      return;
    case Wire::Time:
      return take_time(rest);
    default:
      return;
  }
}

void RoomTransport::take_time(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != 16) return;
  const auto sent = static_cast<std::int64_t>(read_u64(bytes, 0));
  const std::int64_t now = steady();
  if (sent != asked_ || now < sent) return;
  const std::int64_t round_trip = now - sent;
  const std::int64_t offset =
      static_cast<std::int64_t>(read_u64(bytes, 8)) - (sent + round_trip / 2);
  ++questions_;
  if (questions_ < kFirstQuestions) asked_ = INT64_MIN / 2;  // the next at once
  // The quickest answer is the most accurate; later ones follow the drift, slowly.
  if (!offset_ || round_trip <= best_round_trip_) {
    best_round_trip_ = round_trip;
    if (!offset_ || questions_ <= kFirstQuestions) {
      offset_ = offset;
      return;
    }
  }
  constexpr std::int64_t kMostSlew = 1'000'000;
  const std::int64_t way = offset - *offset_;
  if (round_trip < 2 * best_round_trip_ + kMostSlew)
    *offset_ += std::clamp(way, -kMostSlew, kMostSlew);
}

void RoomTransport::greet(MemberId to) {
  if (to == 0 || to == self_) return;
  const auto* const first = reinterpret_cast<const std::uint8_t*>(profile_.data());
  const Bytes hello = cipher_.hello({first, profile_.size()});
  Bytes out = message(Wire::Reliable, to);
  out.insert(out.end(), hello.begin(), hello.end());
  link_.send(std::move(out));
}

void RoomTransport::open(MemberId from, View sealed) {
  constexpr std::uint8_t kNothing[] = {'{', '}'};
  const Cipher::Kind kind = cipher_.open(from, sealed, plain_);
  if (kind == Cipher::Kind::Refused) {
    ++refused_;
    return;
  }
  // Ids that the server invents are not stored, and the cipher limits their number.
  Member& member = members_[from];
  switch (kind) {
    case Cipher::Kind::Refused:
      return;
    case Cipher::Kind::Hello:
      greet(from);
      [[fallthrough]];
    case Cipher::Kind::Known:
      // A packet proves to the other end that the hello is not a recording.
      if (!member.here) send(from, Channel::Words, kNothing);
      return;
    case Cipher::Kind::Packet:
      break;
  }
  if (plain_.empty() || member.dropped) return;
  if (!member.here) {
    member = {.here = true};
    newcomers_.push_back(from);
  }
  const auto channel = static_cast<Channel>(plain_[0]);
  if (channel == Channel::Newest || channel == Channel::Reliable) {
    if (member.away) return;
    consensus::Packet packet;
    packet.from = from;
    const auto* const first = reinterpret_cast<const std::byte*>(plain_.data());
    packet.bytes.assign(first + 1, first + plain_.size());
    packets_.push_back(std::move(packet));
  } else {
    heard_.push_back({from, channel, Bytes(plain_.begin() + 1, plain_.end())});
  }
}

}  // namespace tandem::room
