// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_connection.h"

#include <algorithm>

#include "require.h"
#include "tandem/pbd/bytes.h"
#include "wire.h"

namespace tandem::net {

namespace {

constexpr int kGoodbyes = 3;                      // any of them may be lost
constexpr std::int64_t kGoodbyeGap = 20'000'000;  // ns
constexpr std::int64_t kLossCheck = 10'000'000;   // ns, precision of timeouts
static_assert(kProtectedOverhead + kChannelHeader + kPieceHeader + kMaxPieceBytes <=
              MtuSearch::kMin);

}  // namespace

UdpConnection::UdpConnection(const Session& session, const UdpConnectionOptions& options,
                             bool began_here, std::int64_t now)
    : session_(session),
      options_(options),
      sealer_(session.send, session.remote.receiver, now, options.rekey),
      opener_(session.receive),
      channels_(options.channels, options.max_datagram),
      rate_(options.congestion, now),
      clock_turns_(now),
      began_here_(began_here),
      silence_{
          .heard = now,
          .sent = now - options.idle_timeout,  // so that the first packet leaves at once
          .patience =
              began_here ? std::min(options.idle_timeout, kConfirmTime) : options.idle_timeout,
          .idle_keep_alive =
              std::min(options.idle_timeout,
                       std::max<std::int64_t>(session.remote.idle_timeout_ms, 40) * 1'000'000) /
              4} {
  require(options.max_datagram >= MtuSearch::kMin && options.max_datagram <= kMaxDatagram,
          "UdpConnectionOptions", "max_datagram", options.max_datagram, "in [548, 1472]");
  require(options.congestion.min_kbit > 0.0 &&
              options.congestion.min_kbit <= options.congestion.max_kbit,
          "CongestionOptions", "min_kbit", options.congestion.min_kbit, "in (0, max_kbit]");
}

bool UdpConnection::post(std::span<const std::byte> bytes, consensus::Delivery delivery,
                         std::int64_t now) {
  if (state_ != State::Open) return false;
  return delivery == consensus::Delivery::Reliable ? channels_.post_reliable(bytes)
                                                   : channels_.post_state(bytes, room(), now);
}

std::span<const std::byte> UdpConnection::seal(std::int64_t now) {
  if (!sealer_.seal(plain_, now, datagram_)) {
    close("sequence numbers have run out");
    return {};
  }
  silence_.sent = now;
  return datagram_;
}

std::span<const std::byte> UdpConnection::poll(std::int64_t now, const ClockClaim* clock) {
  if (state_ == State::Closed) return {};
  if (state_ == State::Leaving) {
    if (now < goodbyes_.due) return {};
    if (goodbyes_.left == 0) {
      state_ = State::Closed;
      return {};
    }
    --goodbyes_.left;
    goodbyes_.due = now + kGoodbyeGap;
    plain_.clear();
    encode(ChannelHeader{}, plain_);
    encode({.kind = ChannelSection::Kind::Goodbye, .bytes = std::as_bytes(std::span(reason_))},
           plain_);
    return seal(now);
  }
  if (now - silence_.heard > silence_.patience) {
    close("connection lost: nothing heard for " + std::to_string(silence_.patience / 1'000'000) +
          " ms");
    return {};
  }
  if (!may_send()) return {};
  channels_.on_time(now);
  rate_.update(channels_.take_feedback(), channels_.rtt(), now);
  Pacer& pacer = rate_.pacer();

  // Not before the other end has answered: else a lost probe says nothing.
  const std::size_t probe = channels_.rtt().any() ? channels_.probe_due(now) : 0;
  if (probe != 0 && pacer.ready(now)) {
    plain_.clear();
    channels_.write_probe(sealer_.next_sequence(), probe, congestion().rate(), now, plain_);
    const auto out = seal(now);
    pacer.spend(out.size());
    return out;
  }

  // Acknowledgements alone are small and are not delayed: late ones would look like loss.
  if (clock != nullptr) clock_turns_.begin(now);
  const bool tells_clock = clock != nullptr && clock_turns_.is_due_alone(now);
  const bool must =
      tells_clock || now >= channels_.ack_due() || now - silence_.sent >= silence_.keep_alive();
  const bool content = channels_.has_content(now);
  const bool ready = pacer.ready(now);
  if (content && !ready) rate_.hold_back();
  if (!must && !(content && ready)) return {};
  plain_.clear();
  // The clock may delay a long state to the next packet only once in a while.
  const bool rides =
      clock != nullptr && clock_turns_.rides(now) && ready && channels_.fits(room() - kClockBytes);
  if (!tells_clock && !rides) clock = nullptr;
  if (clock != nullptr) clock_turns_.told(now);
  const std::size_t least = kChannelHeader + (clock != nullptr ? kClockBytes : 0);
  channels_.write(sealer_.next_sequence(), ready ? room() : least, now, clock, plain_);
  const auto out = seal(now);
  pacer.spend(out.size());
  return out;
}

std::int64_t UdpConnection::next_due(std::int64_t now) {
  if (state_ == State::Closed) return INT64_MAX;
  if (state_ == State::Leaving) return goodbyes_.due;
  if (!may_send()) return std::max(now, silence_.heard + silence_.patience + 1);
  std::int64_t due = std::min({channels_.ack_due(), silence_.sent + silence_.keep_alive(),
                               silence_.heard + silence_.patience + 1, clock_turns_.next_due(now)});
  if (channels_.rtt().any()) {
    due = std::min(due, std::max(channels_.mtu().next_due(), rate_.pacer().next(now)));
  }
  if (channels_.has_content(now)) due = std::min(due, rate_.pacer().next(now));
  if (!channels_.reliable().empty()) due = std::min(due, now + kLossCheck);
  return std::max(due, now);
}

bool UdpConnection::open(std::span<const std::byte> datagram, std::int64_t now) {
  opened_.reset();
  if (state_ == State::Closed) return false;
  opened_ = opener_.open(datagram, buffer_);
  if (!opened_) return false;
  silence_.confirmed = true;
  silence_.patience = options_.idle_timeout;
  silence_.heard = now;
  return true;
}

std::span<const std::byte> UdpConnection::seal(const Relayed& relayed, std::int64_t now) {
  if (state_ != State::Open || relayed.datagram.size() > kMaxRelayed) return {};
  plain_.clear();
  pbd::ByteWriter writer(plain_);
  writer.u8(relayed.forward ? 1 : 0);
  writer.u64(relayed.peer);
  writer.bytes(relayed.datagram);
  const std::uint64_t sequence = sealer_.next_sequence();
  if (!sealer_.seal(plain_, now, datagram_, true)) {
    close("sequence numbers have run out");
    return {};
  }
  channels_.note_other(sequence, now);
  rate_.pacer().spend(datagram_.size());
  return datagram_;
}

std::span<const std::byte> UdpConnection::seal_path(ChannelSection::Kind kind, std::uint64_t token,
                                                    std::int64_t now) {
  if (state_ != State::Open) return {};
  plain_.clear();
  encode(ChannelHeader{}, plain_);
  encode({.kind = kind, .token = token}, plain_);
  channels_.note_other(sealer_.next_sequence(), now);
  const auto out = seal(now);
  rate_.pacer().spend(out.size());
  return out;
}

void UdpConnection::begin_path(std::int64_t now) {
  channels_.begin_path();
  rate_.begin_path(now);
}

void UdpConnection::read(std::int64_t now) {
  const auto opened = std::exchange(opened_, {});
  if (!opened || state_ != State::Open) return;
  if (opened->relay) {
    pbd::ByteReader reader(opened->plain);
    const std::uint8_t direction = reader.u8();
    const consensus::PeerId peer = reader.u64();
    if (reader.failed() || direction > 1 || reader.remaining() == 0) {
      ++rejected_;
      leave("dropped: packet cannot be decoded", now);
      return;
    }
    relayed_ = {.forward = direction == 1,
                .peer = peer,
                .datagram = opened->plain.last(reader.remaining())};
    return;
  }
  switch (channels_.read(opened->sequence, opened->plain, now)) {
    case Channels::Read::Ok:
    case Channels::Read::Full:
      // A peer that was dropped may come back after a while, with a new budget.
      if (channels_.inbox().budget().abused())
        leave(std::string("dropped: ") + MemberBudget::kReason, now);
      break;
    case Channels::Read::Malformed:
      ++rejected_;
      leave("dropped: packet cannot be decoded", now);
      break;
    case Channels::Read::Goodbye:
      close("peer: " + decode_reason(channels_.inbox().goodbye()));
      break;
  }
}

void UdpConnection::leave(const std::string& reason, std::int64_t now) {
  if (state_ != State::Open) return;
  if (!may_send()) return close(reason);
  state_ = State::Leaving;
  reason_ = (reason.empty() ? std::string("closed") : reason).substr(0, kMaxReason);
  goodbyes_ = {.left = kGoodbyes, .due = now};
}

void UdpConnection::close(const std::string& reason) {
  state_ = State::Closed;
  reason_ = reason;
}

}  // namespace tandem::net
