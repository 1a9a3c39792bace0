// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "connection_path.h"

#include <algorithm>
#include <utility>

namespace tandem::net {

bool ConnectionPath::may_move_to(const Address& address) const {
  return link_->confirmed() && link_->state() == UdpConnection::State::Open &&
         !is_relayed(address_) && !is_relayed(address);
}

void ConnectionPath::on_elsewhere(const Address& from, std::uint64_t sequence, std::size_t bytes,
                                  const crypto::Random& random, std::int64_t now) {
  // Only the newest packet shows where a peer is: an older one was overtaken, or held back.
  if (link_->is_newest() && (!moving_ || moving_->address() != from)) {
    moving_.emplace(from, sequence, random_token(random), now);
  }
  if (moving_ && moving_->address() == from) moving_->came(bytes);
}

void ConnectionPath::on_read(const Address& from, const SendDatagram& send, std::int64_t now) {
  ChannelInbox& inbox = link_->channels().inbox();
  if (const auto token = inbox.take_challenge()) {
    // Answered on the path of the challenge, as it tests that path.
    const auto sealed = link_->seal_answer(*token, now);
    if (!sealed.empty()) send(sealed, from);
    if (direct_ && from != direct_->address()) direct_->exclude_before(link_->next_sequence());
  }
  const auto answer = inbox.take_answer();
  if (direct_) {
    if (from != address_) direct_->on_heard(from);
    if (answer) direct_->on_answer(*answer, *link_, now);
  }
  if (answer && moving_ && *answer == moving_->token()) moving_->answered();
}

void ConnectionPath::on_rumour(const Address& to, std::int64_t now) {
  if (!may_move_to(to) || to == address_) return;
  if (!rumour_) rumour_.emplace(to, now);
}

void ConnectionPath::poll_rumour(const SendDatagram& send, std::int64_t now) {
  if (!rumour_) return;
  if (rumour_->is_over(now)) return rumour_.reset();
  if (now < next_due(now)) return;
  // No token: if the peer is there, its challenge follows this one.
  const auto sealed = link_->seal_challenge(kNoToken, now);
  if (!sealed.empty()) send(sealed, rumour_->address());
  rumour_->asked(now);
  question_due_ = now + PathValidation::kResend;
}

std::int64_t ConnectionPath::next_due(std::int64_t now) const {
  std::int64_t due = 0;
  if (moving_) {
    due = moving_->next_due(UdpConnection::kQuestionBytes, patience());
  } else if (rumour_) {
    due = std::max(rumour_->next_due(), link_->last_heard() + PathRumour::kQuiet);
  } else {
    return INT64_MAX;
  }
  return std::max({now, question_due_, due});
}

void ConnectionPath::send(std::span<const std::byte> datagram, const SendDatagram& send) {
  if (!direct_ || direct_->uses_path()) send(datagram, address_);
  if (direct_ && direct_->uses_direct()) send(datagram, direct_->address());
}

bool ConnectionPath::poll(const SendDatagram& send, const crypto::Random& random,
                          std::int64_t now) {
  if (direct_) direct_->poll(*link_, send, random, now);
  if (!moving_) {
    poll_rumour(send, now);
    return false;
  }
  if (moving_->has_succeeded(patience(), now)) {
    follow(now);
    return true;
  }
  if (moving_->has_failed(now)) {
    moving_.reset();
    return false;
  }
  if (now < question_due_ || !moving_->due(UdpConnection::kQuestionBytes, now)) return false;
  question_due_ = now + PathValidation::kResend;
  // A peer that has not moved answers from its old address.
  if (moving_->is_first()) {
    const auto sealed = link_->seal_challenge(kNoToken, now);
    if (!sealed.empty()) send(sealed, address_);
  }
  const auto sealed = link_->seal_challenge(moving_->token(), now);
  if (sealed.empty()) return false;
  send(sealed, moving_->address());
  moving_->sent(sealed.size(), now);
  return false;
}

void ConnectionPath::follow(std::int64_t now) {
  const Address old = std::exchange(address_, moving_->address());
  moving_.reset();
  rumour_.reset();
  // A new port on the same address is the same path, through the same NAT (RFC 9000, Sec. 9.4).
  if (old.ip != address_.ip) link_->begin_path(now);
}

}  // namespace tandem::net
