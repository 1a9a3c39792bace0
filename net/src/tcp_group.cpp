// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// TcpMesh: who is no member any more, and a group key that changes while a session goes on.
#include <asio/post.hpp>
#include <utility>

#include "tcp_mesh.h"

namespace tandem::net {

void TcpMesh::change_group(std::vector<std::byte> signed_change) {
  asio::post(context_, [this, change = std::move(signed_change)] {
    if (security_) take_group_change(change);
  });
}

TcpSecurity::Changed TcpMesh::take_group_change(std::span<const std::byte> change) {
  const auto changed = security_->change_group(change);
  if (changed != TcpSecurity::Changed::Yes) return changed;
  group_ = security_->group();
  expel();
  for (const auto& link : snapshot()) {
    if (link->phase == TcpLink::Phase::Attached) send_group_change(*link);
  }
  return changed;
}

void TcpMesh::on_group_change(TcpLink& link, std::span<const std::byte> change) {
  // Everybody checks it, so that nobody passes on what the organiser has not signed.
  if (security_ && take_group_change(change) != TcpSecurity::Changed::Forged) return;
  on_malformed(link, "group change that the organiser has not signed");
}

void TcpMesh::send_group_change(TcpLink& link) {
  if (!security_ || security_->group_change().empty()) return;
  link.send(FrameType::GroupChange,
            [&](pbd::ByteWriter& writer) { writer.bytes(security_->group_change()); });
}

void TcpMesh::expel() {
  for (const auto& link : snapshot()) {
    if (link->phase != TcpLink::Phase::Attached && link->phase != TcpLink::Phase::Welcoming) {
      continue;
    }
    const std::string reason = security_->expelled(link->member);
    if (reason.empty()) continue;
    table_.expel(link->serial(), link->hello.peer, reason);
    link->leave(reason, Clock::now() + kLinger);
  }
}

}  // namespace tandem::net
