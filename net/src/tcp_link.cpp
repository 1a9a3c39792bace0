// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_link.h"

#include <asio/buffer.hpp>
#include <asio/error.hpp>
#include <asio/write.hpp>
#include <chrono>

namespace tandem::net {

void TcpLink::start(std::size_t send_buffer) {
  // Without these options it is slower, not wrong.
  std::error_code ignored;
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket_.set_option(asio::socket_base::send_buffer_size(static_cast<int>(send_buffer)), ignored);
  std::error_code error;
  const auto endpoint = socket_.remote_endpoint(error);
  if (error) return close("connection lost: " + error.message());
  remote = endpoint.address();
  times.heard = times.sent = std::chrono::steady_clock::now();
  read();
}

void TcpLink::read() {
  const auto space = input_.space();
  socket_.async_read_some(
      asio::buffer(space.data(), space.size()),
      [self = shared_from_this()](const std::error_code& error, std::size_t count) {
        self->on_read(error, count);
      });
}

void TcpLink::on_read(const std::error_code& error, std::size_t count) {
  if (phase == Phase::Closed) return;
  if (error) {
    const bool ended = error == asio::error::eof;
    return close(ended ? "connection lost: closed by the other end"
                       : "connection lost: " + error.message());
  }
  times.heard = std::chrono::steady_clock::now();
  input_.filled(count);
  take_frames();
  if (phase == Phase::Closed) return;
  // Unread bytes would reset the connection, and the other end would lose the Goodbye.
  if (phase == Phase::Leaving) input_.discard();
  kick();  // an acknowledgement may be due
  if (phase == Phase::Closed) return;
  paused_ = !owner_.may_read(*this);
  if (!paused_) read();
}

void TcpLink::resume() {
  if (!paused_ || phase == Phase::Closed || !owner_.may_read(*this)) return;
  paused_ = false;
  times.heard = std::chrono::steady_clock::now();  // it may have sent all the time
  read();
}

void TcpLink::take_frames() {
  while (phase != Phase::Leaving && phase != Phase::Closed) {
    if (!cipher_) {
      const auto frame = input_.next();
      if (!frame) break;
      owner_.on_frame(*this, *frame);
      continue;
    }
    const auto whole = input_.next_whole(1 + kSealBytes);
    if (!whole) break;
    const auto body = cipher_->opener.open(*whole);
    if (!body) return owner_.on_forged(*this, "frame not sealed by the other end");
    if (body->empty()) continue;
    owner_.on_frame(*this, {static_cast<FrameType>(body->front()), body->subspan(1)});
  }
  if (!input_.bad() || phase == Phase::Leaving || phase == Phase::Closed) return;
  // A sealed length is verified only with its frame; until then it is untrusted.
  if (cipher_) return owner_.on_forged(*this, input_.error());
  owner_.on_malformed(*this, input_.error());
}

void TcpLink::protect(std::unique_ptr<LinkCipher> cipher) {
  if (!output_.control.empty()) return close("internal: frames in the clear are waiting");
  cipher_ = std::move(cipher);
  raise_limit(kMaxControlFrame);
}

void TcpLink::kick() {
  if (output_.writing || phase == Phase::Closed || phase == Phase::Connecting) return;
  output_.written.clear();
  output_.written.swap(output_.control);
  if (phase == Phase::Attached || goodbye_) owner_.on_writable(*this, output_.written);
  if (output_.written.empty()) {
    if (!goodbye_) return;
    if (goodbye_->empty()) {  // the Goodbye was sent
      std::error_code ignored;
      socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
      return;
    }
    append_frame(output_.written, FrameType::Goodbye, [&](pbd::ByteWriter& writer) {
      writer.bytes(std::as_bytes(std::span(*goodbye_)));
    });
    goodbye_->clear();
  }
  if (cipher_) {
    output_.sealed.clear();
    if (!cipher_->sealer.seal(output_.written, nanoseconds(std::chrono::steady_clock::now()),
                              output_.sealed)) {
      return close("connection lost: no sequence numbers left");
    }
    output_.written.swap(output_.sealed);
  }
  output_.writing = true;
  asio::async_write(socket_, asio::buffer(output_.written.data(), output_.written.size()),
                    [self = shared_from_this()](const std::error_code& error, std::size_t) {
                      self->output_.writing = false;
                      if (self->phase == Phase::Closed) return;
                      if (error) return self->close("connection lost: " + error.message());
                      self->times.sent = std::chrono::steady_clock::now();
                      self->kick();
                    });
}

void TcpLink::leave(const std::string& reason, SteadyTime until) {
  if (phase == Phase::Leaving || phase == Phase::Closed) return;
  if (phase == Phase::Connecting) return close(reason);
  goodbye_ = reason.empty() ? std::string("closed") : reason.substr(0, kMaxReason);
  failure = reason;
  phase = Phase::Leaving;
  deadline = until;
  kick();
}

void TcpLink::close(const std::string& reason) {
  if (phase == Phase::Closed) return;
  const auto keep = shared_from_this();
  phase = Phase::Closed;
  std::error_code ignored;
  socket_.close(ignored);
  owner_.on_closed(*this, failure.empty() ? reason : failure);
}

}  // namespace tandem::net
