// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "server/member_socket.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <chrono>
#include <utility>

namespace tandem::room {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kIdle{15};      // for a member that is gone
constexpr std::chrono::seconds kHandshake{3};  // for opening, closing and joining
constexpr int kSocketBytes = 128 * 1024;       // data queued in the system is old when it is read

}  // namespace

MemberSocket::MemberSocket(MemberHost& host, std::string room, const MemberLimits& limits,
                           beast::tcp_stream&& stream)
    : host_(host),
      room_(std::move(room)),
      limits_(limits),
      socket_(std::move(stream)),
      patience_(socket_.get_executor()),
      messages_(limits.messages_per_s),
      bytes_(limits.bytes_per_s) {}

void MemberSocket::start(Request request) {
  request_ = std::move(request);
  beast::get_lowest_layer(socket_).expires_never();
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = kHandshake;
  timeout.idle_timeout = kIdle;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(kMaxWireBytes);
  socket_.auto_fragment(false);
  socket_.binary(true);
  Error ignored;
  beast::get_lowest_layer(socket_).socket().set_option(
      asio::socket_base::send_buffer_size(kSocketBytes), ignored);
  patience_.expires_after(2 * kHandshake);
  patience_.async_wait([self = shared_from_this()](Error error) {
    if (!error && self->id_ == 0) self->close();
  });
  socket_.async_accept(request_, [self = shared_from_this()](Error error) {
    if (error) return self->close();
    self->open_ = true;
    self->read();
  });
}

void MemberSocket::read() {
  socket_.async_read(incoming_, [self = shared_from_this()](Error error, std::size_t size) {
    if (error || self->closed_) return self->close();
    const auto now = page_server::Allowance::Clock::now();
    if (!self->messages_.take(now) || !self->bytes_.take(now, static_cast<double>(size))) {
      return self->end(websocket::close_code::try_again_later);
    }
    const auto data = self->incoming_.data();
    const bool good = self->socket_.got_binary() &&
                      self->hear({static_cast<const std::uint8_t*>(data.data()), data.size()});
    self->incoming_.consume(self->incoming_.size());
    if (!good) return self->end(websocket::close_code::policy_error);
    if (!self->closed_) self->read();
  });
}

bool MemberSocket::hear(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kWireHeader) return false;
  const auto kind = static_cast<Wire>(bytes[0]);
  const std::uint64_t value = read_u64(bytes, 1);
  if (id_ == 0) {
    if (kind != Wire::Join || bytes.size() != kWireHeader || value == 0) return false;
    id_ = value;
    if (host_.join(*this, value)) return true;
    id_ = 0;
    return false;
  }
  switch (kind) {
    case Wire::Newest:
    case Wire::Reliable: {
      if (bytes.size() == kWireHeader) return false;
      std::vector<std::uint8_t> out = message(kind, id_);
      out.insert(out.end(), bytes.begin() + kWireHeader, bytes.end());
      host_.relay(*this, value, std::make_shared<const std::vector<std::uint8_t>>(std::move(out)),
                  kind == Wire::Reliable);
      return true;
    }
    case Wire::Time: {
      if (bytes.size() != kWireHeader) return false;
      std::vector<std::uint8_t> out = message(Wire::Time, value);
      append_u64(out, static_cast<std::uint64_t>(host_.now()));
      send(std::make_shared<const std::vector<std::uint8_t>>(std::move(out)), false);
      return true;
    }
    default:
      return false;
  }
}

void MemberSocket::send(Message message, bool reliable) {
  if (closed_ || !open_) return;
  waiting_bytes_ += message->size();
  waiting_.push_back({std::move(message), reliable});
  for (auto at = waiting_.begin(); waiting_bytes_ > limits_.queue_bytes && at != waiting_.end();) {
    if (at->reliable) {
      ++at;
      continue;
    }
    waiting_bytes_ -= at->message->size();
    at = waiting_.erase(at);
    host_.dropped();
  }
  if (waiting_bytes_ > limits_.reliable_bytes) return end(websocket::close_code::try_again_later);
  write();
}

void MemberSocket::write() {
  if (writing_ || waiting_.empty() || closed_) return;
  writing_ = std::move(waiting_.front().message);
  waiting_.pop_front();
  waiting_bytes_ -= writing_->size();
  socket_.async_write(asio::buffer(*writing_),
                      [self = shared_from_this()](Error error, std::size_t) {
                        self->writing_.reset();
                        if (error) return self->close();
                        self->write();
                      });
}

void MemberSocket::end(websocket::close_code code) {
  if (closed_ || !open_) return close();
  waiting_.clear();
  waiting_bytes_ = 0;
  if (writing_) return close();
  open_ = false;  // nothing more is sent
  host_.gone(*this);
  socket_.async_close(code, [self = shared_from_this()](Error) { self->close(); });
}

void MemberSocket::close() {
  if (std::exchange(closed_, true)) return;
  patience_.cancel();
  Error ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
  host_.gone(*this);
}

}  // namespace tandem::room
