// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who is no member any more, and a group key that changes while a session goes on.
#include "udp_node.h"

namespace tandem::net {

Credentials::Changed UdpNode::change_group(std::span<const std::byte> signed_change,
                                           std::int64_t now) {
  now_ = now;
  HandshakeConfig& own = options_.handshake;
  const auto changed = own.change(signed_change, own.scene_hash);
  if (changed != Credentials::Changed::Yes) return changed;
  expel(now);
  for (auto& [receiver, connection] : connections_) {
    if (connection.attached) connection.link->channels().post_group_change(own.group_change);
  }
  for (Dial& dial : dials_) {
    dial.attempts = 0;
    dial.attempt.reset();
  }
  return changed;
}

void UdpNode::on_group_change(Connection& connection, std::span<const std::byte> change,
                              std::int64_t now) {
  // Everybody checks it, so that nobody passes on what the organiser has not signed.
  if (change_group(change, now) == Credentials::Changed::Forged && options_.handshake.organiser) {
    connection.link->leave("dropped: group change that the organiser has not signed", now);
  }
}

void UdpNode::expel(std::int64_t now) {
  for (auto& [receiver, connection] : connections_) {
    const Member& member = connection.link->session().member;
    if (options_.handshake.stands(member)) continue;
    const bool revoked = options_.handshake.is_revoked(member.key);
    connection.link->leave(describe(revoked ? Verdict::Revoked : Verdict::Expired), now);
    if (!connection.attached) continue;
    detach(connection);
    Record& record = records_.at(connection.link->session().remote.peer);
    record.inbox.clear();
    record.reliable.reset();
  }
}

}  // namespace tandem::net
