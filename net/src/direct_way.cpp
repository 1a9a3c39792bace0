// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "direct_way.h"

namespace tandem::net {

std::uint64_t random_token(const crypto::Random& random) {
  std::uint64_t out = kNoToken;
  while (out == kNoToken) out = crypto::random_number(random);
  return out;
}

void DirectWay::want(bool wanted, UdpConnection& link, std::int64_t now) {
  if (wanted == wanted_) return;
  wanted_ = wanted;
  // Toggling must not increase the rate of challenges.
  const std::int64_t rest = rest_;
  if (!wanted && state_ != State::Search) fall(link, now);
  rest_ = rest;
}

void DirectWay::offer(const Address& address) {
  if (!is_host(address) || std::ranges::find(offered_, address) != offered_.end()) return;
  if (offered_.size() >= kMaxOffered) offered_.erase(offered_.begin());
  offered_.push_back(address);
}

void DirectWay::on_answer(std::uint64_t token, UdpConnection& link, std::int64_t now) {
  const auto at = std::ranges::find(asked_, token, &Asked::token);
  if (token == kNoToken || at == asked_.end()) return;
  const Asked asked = *at;
  *at = {};
  if (!wanted_ || asked.at < since_) return;
  round_trip_ = now - asked.at;
  if (state_ == State::Search) {
    proofs_ = asked.address == address_ ? proofs_ + 1 : 1;
    address_ = asked.address;
    if (proofs_ >= kProofs) rise(link, now);
  } else if (asked.address == address_) {
    unproven_ = std::max(unproven_, asked.sequence);
    if (state_ == State::Doubt) {
      state_ = State::Up;
      first_ = link.next_sequence();
    }
  }
}

void DirectWay::rise(UdpConnection& link, std::int64_t now) {
  state_ = State::Up;
  since_ = now;
  first_ = link.next_sequence();
  proofs_ = 0;
  unproven_ = first_;
  link.begin_path(now);
}

void DirectWay::fall(UdpConnection& link, std::int64_t now) {
  state_ = State::Search;
  since_ = now;
  proofs_ = 0;
  asks_ = 0;
  ask_due_ = now + rest_;
  rest_ = std::min(2 * rest_, kMaxRest);
  link.begin_path(now);
}

void DirectWay::look_at_acknowledged(const UdpConnection& link) {
  const std::uint64_t acknowledged = link.channels().highest_acknowledged();
  if (acknowledged >= first_) unproven_ = std::max(unproven_, acknowledged + 1);
}

void DirectWay::ask(const Address& address, UdpConnection& link, const SendDatagram& send,
                    const crypto::Random& random, std::int64_t now) {
  Asked& asked = asked_[next_asked_++ % asked_.size()];
  asked = {random_token(random), address, now};
  const auto sealed = link.seal_challenge(asked.token, now);
  asked.sequence = link.next_sequence();
  if (!sealed.empty()) send(sealed, address);
}

void DirectWay::search(UdpConnection& link, const SendDatagram& send, const crypto::Random& random,
                       std::int64_t now) {
  if (now < ask_due_ || offered_.empty()) return;
  if (asks_ >= kAsks) {
    proofs_ = 0;
    asks_ = 0;
    ask_due_ = now + rest_;
    rest_ = std::min(2 * rest_, kMaxRest);
    return;
  }
  ++asks_;
  ask_due_ = now + kAskEvery;
  // Once an address has answered, only that one is asked.
  if (proofs_ > 0) return ask(address_, link, send, random, now);
  for (const Address& address : offered_) ask(address, link, send, random, now);
}

void DirectWay::poll(UdpConnection& link, const SendDatagram& send, const crypto::Random& random,
                     std::int64_t now) {
  if (!wanted_ || link.state() != UdpConnection::State::Open) return;
  if (state_ == State::Search) return search(link, send, random, now);
  if (state_ == State::Up) {
    look_at_acknowledged(link);
    if (now - since_ > kSteady) rest_ = kMinRest;
    const std::int64_t waiting_since = link.channels().first_sent_from(unproven_);
    if (waiting_since == INT64_MAX || now - waiting_since <= patience() / 2) return;
    if (now - waiting_since > patience()) {
      state_ = State::Doubt;
      since_ = now;
      ask_due_ = now;
    }
  } else if (now - since_ > kDoubt) {
    return fall(link, now);
  }
  if (now < ask_due_) return;
  ask_due_ = now + kAskEvery / 2;
  ask(address_, link, send, random, now);
}

}  // namespace tandem::net
