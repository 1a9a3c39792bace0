// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "proxy/flow.h"

#include <algorithm>
#include <asio/buffer.hpp>
#include <system_error>

namespace tandem::demos {

using consensus::SessionTime;

Flow::Flow(asio::io_context& io, asio::ip::udp::socket& entrance, const Endpoint& client,
           const Endpoint& target, const consensus::LinkOptions& link, std::uint64_t seed)
    : entrance_(entrance),
      exit_(io, Endpoint(target.protocol(), 0)),
      timer_(io),
      client_(client),
      target_(target),
      network_(link, seed),
      client_end_(network_.transport(kClient)),
      target_end_(network_.transport(kTarget)) {}

void Flow::forward(std::span<const std::byte> datagram) {
  last_heard_ = Clock::now();
  carry(kClient, kTarget, datagram);
}

void Flow::end() {
  std::error_code ignored;
  exit_.close(ignored);
  timer_.cancel();
}

void Flow::receive() {
  exit_.async_receive_from(
      asio::buffer(buffer_), sender_,
      [self = shared_from_this()](const std::error_code& error, std::size_t size) {
        if (error == asio::error::operation_aborted || !self->exit_.is_open()) return;
        // Packets from strangers are dropped; a refusal by the target's host does not end the flow.
        if (!error && self->sender_ == self->target_) {
          self->carry(kTarget, kClient, std::span(self->buffer_).first(size));
        }
        self->receive();
      });
}

void Flow::carry(consensus::PeerId from, consensus::PeerId to,
                 std::span<const std::byte> datagram) {
  network_.advance_to(std::max(network_.now(), now()));
  network_.transport(from).post(to, datagram, consensus::Delivery::Newest);
  deliver();
}

void Flow::deliver() {
  network_.advance_to(std::max(network_.now(), now()));
  std::error_code lost;  // a failed send is one more loss
  arrived_.clear();
  target_end_.drain(arrived_);
  for (const consensus::Packet& packet : arrived_) {
    exit_.send_to(asio::buffer(packet.bytes), target_, 0, lost);
  }
  arrived_.clear();
  client_end_.drain(arrived_);
  for (const consensus::Packet& packet : arrived_) {
    entrance_.send_to(asio::buffer(packet.bytes), client_, 0, lost);
  }
  const auto next = network_.next_event();
  if (!next) return;
  timer_.expires_at(start_ + std::chrono::nanoseconds(*next));
  timer_.async_wait([self = shared_from_this()](const std::error_code& error) {
    if (!error && self->exit_.is_open()) self->deliver();
  });
}

SessionTime Flow::now() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_).count();
}

}  // namespace tandem::demos
