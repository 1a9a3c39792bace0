// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_connection.h"

#include <algorithm>

#include "require.h"
#include "wire.h"

namespace tandem::net {

namespace {

constexpr int kGoodbyes = 3;                      // any of them may be lost
constexpr std::int64_t kGoodbyeGap = 20'000'000;  // ns
constexpr std::int64_t kLossCheck = 10'000'000;   // ns, how exactly a timeout is kept
constexpr std::size_t kMinDatagram = 548;
static_assert(kProtectedOverhead + kChannelHeader + kPieceHeader + kMaxPieceBytes <= kMinDatagram);

}  // namespace

UdpConnection::UdpConnection(const Session& session, const UdpConnectionOptions& options,
                             bool confirmed, std::int64_t now)
    : session_(session),
      options_(options),
      sealer_(session.send, session.remote.receiver, now, options.rekey),
      opener_(session.receive),
      channels_(options.channels),
      pacer_(options.congestion.max_kbit, now),
      congestion_(options.congestion, now),
      confirmed_(confirmed),
      last_heard_(now),
      last_sent_(now - options.idle_timeout),  // the first packet tells the other end at once
      keep_alive_(std::min(options.idle_timeout,
                           std::max<std::int64_t>(session.remote.idle_timeout_ms, 40) * 1'000'000) /
                  4) {
  require(options.max_datagram >= kMinDatagram && options.max_datagram <= kMaxDatagram,
          "UdpConnectionOptions", "max_datagram", options.max_datagram, "in [548, 1200]");
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
  last_sent_ = now;
  return datagram_;
}

std::span<const std::byte> UdpConnection::poll(std::int64_t now) {
  if (state_ == State::Closed) return {};
  if (state_ == State::Leaving) {
    if (now < goodbye_due_) return {};
    if (goodbyes_ == 0) {
      state_ = State::Closed;
      return {};
    }
    --goodbyes_;
    goodbye_due_ = now + kGoodbyeGap;
    plain_.clear();
    encode(ChannelHeader{}, plain_);
    encode({.kind = ChannelSection::Kind::Goodbye, .bytes = std::as_bytes(std::span(reason_))},
           plain_);
    return seal(now);
  }
  if (now - last_heard_ > options_.idle_timeout) {
    close("connection lost: nothing heard for " +
          std::to_string(options_.idle_timeout / 1'000'000) + " ms");
    return {};
  }
  channels_.on_time(now);
  congestion_.update(channels_.take_feedback(), channels_.rtt(), held_back_, now);
  held_back_ = false;
  if (congestion_.rate() != pacer_.rate()) pacer_.set_rate(congestion_.rate(), now);

  // Acknowledgements alone are small and do not wait: late ones would look like loss.
  const bool must = now >= channels_.ack_due() || now - last_sent_ >= keep_alive_;
  const bool content = channels_.has_content(now);
  const bool ready = pacer_.ready(now);
  held_back_ = content && !ready;
  if (!must && !(content && ready)) return {};
  plain_.clear();
  channels_.write(sealer_.next_sequence(), ready ? room() : kChannelHeader, now, plain_);
  const auto out = seal(now);
  pacer_.spend(out.size());
  return out;
}

std::int64_t UdpConnection::next_due(std::int64_t now) {
  if (state_ == State::Closed) return INT64_MAX;
  if (state_ == State::Leaving) return goodbye_due_;
  std::int64_t due = std::min(
      {channels_.ack_due(), last_sent_ + keep_alive_, last_heard_ + options_.idle_timeout + 1});
  if (channels_.has_content(now)) due = std::min(due, pacer_.next(now));
  if (!channels_.reliable().empty()) due = std::min(due, now + kLossCheck);
  return std::max(due, now);
}

bool UdpConnection::on_datagram(std::span<const std::byte> datagram, std::int64_t now) {
  if (state_ == State::Closed) return false;
  const auto opened = opener_.open(datagram, buffer_);
  if (!opened) return false;
  confirmed_ = true;
  last_heard_ = now;
  if (state_ == State::Leaving) return true;
  switch (channels_.read(opened->sequence, opened->plain, now)) {
    case Channels::Read::Ok:
    case Channels::Read::Full:
      break;
    case Channels::Read::Malformed:
      ++rejected_;
      leave("dropped: packet cannot be decoded", now);
      break;
    case Channels::Read::Goodbye:
      close("peer: " + decode_reason(channels_.goodbye()));
      break;
  }
  return true;
}

void UdpConnection::leave(const std::string& reason, std::int64_t now) {
  if (state_ != State::Open) return;
  state_ = State::Leaving;
  reason_ = (reason.empty() ? std::string("closed") : reason).substr(0, kMaxReason);
  goodbyes_ = kGoodbyes;
  goodbye_due_ = now;
}

void UdpConnection::close(const std::string& reason) {
  state_ = State::Closed;
  reason_ = reason;
}

}  // namespace tandem::net
