// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Ways to peers: how long datagrams may be there, and a peer whose address changes while its
// connection goes on.
#include <algorithm>
#include <utility>

#include "udp_node.h"

namespace tandem::net {

bool UdpNode::may_move(const Connection& connection, const Address& to) {
  // A way through a relay is a connection of its own, made with proofs of its own.
  return connection.link->confirmed() && connection.link->state() == UdpConnection::State::Open &&
         !is_relayed(connection.address) && !is_relayed(to);
}

void UdpNode::note_path(Connection& connection, std::uint64_t sequence, const Address& from,
                        std::size_t bytes, std::int64_t now) {
  auto& moving = connection.moving;
  // Only the newest packet says where a peer is: what is older was overtaken, or held back.
  if (connection.link->is_newest() && (!moving || moving->address() != from)) {
    moving.emplace(from, sequence, random_token(), now);
  }
  if (moving && moving->address() == from) moving->came(bytes);
}

void UdpNode::answer_path(Connection& connection, const Address& from, std::int64_t now) {
  if (const auto token = connection.link->channels().inbox().take_challenge()) {
    // On the way on which the question came: it is that way that is asked about.
    const auto sealed = connection.link->seal_answer(*token, now);
    if (!sealed.empty()) transmit(sealed, from);
  }
  const auto answer = connection.link->channels().inbox().take_answer();
  if (answer && connection.moving && *answer == connection.moving->token()) {
    connection.moving->answered();
  }
}

void UdpNode::note_rumour(Connection& connection, const Address& to, std::int64_t now) {
  if (!may_move(connection, to) || to == connection.address) return;
  if (!connection.rumour) connection.rumour.emplace(to, now);
}

void UdpNode::poll_rumour(Connection& connection, std::int64_t now) {
  auto& rumour = connection.rumour;
  if (!rumour) return;
  if (rumour->is_over(now)) return rumour.reset();
  if (now < path_due(connection, now)) return;
  // No token: whether it is there, the question shows that it asks when it has this.
  const auto sealed = connection.link->seal_challenge(kNoToken, now);
  if (!sealed.empty()) transmit(sealed, rumour->address());
  rumour->asked(now);
  connection.question_due = now + PathValidation::kResend;
}

std::int64_t UdpNode::path_due(const Connection& connection, std::int64_t now) {
  std::int64_t due = 0;
  if (connection.moving) {
    due = connection.moving->next_due(UdpConnection::kQuestionBytes,
                                      connection.link->channels().rtt().timeout());
  } else if (connection.rumour) {
    due =
        std::max(connection.rumour->next_due(), connection.link->last_heard() + PathRumour::kQuiet);
  } else {
    return INT64_MAX;
  }
  return std::max({now, connection.question_due, due});
}

void UdpNode::poll_path(Connection& connection, std::int64_t now) {
  auto& moving = connection.moving;
  if (!moving) return poll_rumour(connection, now);
  if (moving->has_succeeded(connection.link->channels().rtt().timeout(), now))
    return move(connection, now);
  if (moving->has_failed(now)) return moving.reset();
  if (now < connection.question_due || !moving->due(UdpConnection::kQuestionBytes, now)) return;
  connection.question_due = now + PathValidation::kResend;
  // Whoever is still where it was answers from there.
  if (moving->is_first()) {
    const auto sealed = connection.link->seal_challenge(kNoToken, now);
    if (!sealed.empty()) transmit(sealed, connection.address);
  }
  const auto sealed = connection.link->seal_challenge(moving->token(), now);
  if (sealed.empty()) return;
  transmit(sealed, moving->address());
  moving->sent(sealed.size(), now);
}

void UdpNode::move(Connection& connection, std::int64_t now) {
  const Address old = std::exchange(connection.address, connection.moving->address());
  connection.moving.reset();
  connection.rumour.reset();
  // Where the others are may have been told to where it was.
  connection.told_to = 0;
  connection.tell_due = now;
  // Another port alone is the same way, through the same NAT (RFC 9000, Sec. 9.4).
  if (old.ip != connection.address.ip) connection.link->begin_path(now);
  ++moves_;
  if (connection.attached) tell_others(connection);
}

std::size_t UdpNode::max_state_bytes() const {
  std::size_t out = SIZE_MAX;
  for (const auto& [receiver, connection] : connections_) {
    if (connection.attached) out = std::min(out, connection.link->channels().mtu().size());
  }
  if (out == SIZE_MAX) out = std::min(MtuSearch::kBase, options_.connection.max_datagram);
  return out - kProtectedOverhead - kChannelHeader - kStateHeader;
}

std::uint64_t UdpNode::random_token() const {
  for (;;) {
    std::array<std::uint8_t, 8> bytes{};
    random_(bytes);
    std::uint64_t out = 0;
    for (const std::uint8_t byte : bytes) out = out << 8 | byte;
    if (out != kNoToken) return out;
  }
}

}  // namespace tandem::net
