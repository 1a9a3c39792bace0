// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/page_socket.h"

#include <chrono>
#include <string_view>
#include <utility>
#include <variant>

namespace tandem::demos::view {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kIdle{10};      // for a page that is gone
constexpr std::chrono::seconds kHandshake{3};  // for opening and for closing a socket
constexpr std::size_t kMaxWords = 256;         // queued for one page
constexpr int kSocketBytes = 64 * 1024;        // data queued in the system is old when it is seen

}  // namespace

PageSocket::PageSocket(PageHost& host, PageId id, const Layout& layout, beast::tcp_stream&& stream)
    : host_(host), id_(id), socket_(std::move(stream)), commands_(layout) {}

void PageSocket::start(Request request) {
  request_ = std::move(request);
  beast::get_lowest_layer(socket_).expires_never();
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = kHandshake;
  timeout.idle_timeout = kIdle;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(kMaxBytes);
  socket_.auto_fragment(false);
  // Data that a slow page has not read is to wait here, where the newest frame wins.
  Error ignored;
  beast::get_lowest_layer(socket_).socket().set_option(
      asio::socket_base::send_buffer_size(kSocketBytes), ignored);
  socket_.async_accept(request_, [self = shared_from_this()](Error error) {
    if (error) return self->close();
    self->open_ = true;
    self->greet();
    self->read();
  });
}

void PageSocket::greet() {
  if (!open_ || greeted_ || host_.hello().empty()) return;
  greeted_ = true;
  words_.push_front(std::make_shared<const std::string>(host_.hello()));
  write();
}

void PageSocket::say(std::shared_ptr<const std::string> text) {
  if (!greeted_ || closed_) return;
  if (words_.size() >= kMaxWords) return close();
  words_.push_back(std::move(text));
  write();
}

void PageSocket::show() {
  if (!greeted_ || closed_) return;
  if (writing_ || !words_.empty()) host_.missed();
  write();
}

void PageSocket::close() {
  if (std::exchange(closed_, true)) return;
  Error ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
  host_.gone(id_, open_);
}

void PageSocket::say_goodbye() {
  if (!open_ || closed_) return close();
  socket_.async_close(websocket::close_code::going_away,
                      [self = shared_from_this()](Error) { self->close(); });
}

void PageSocket::read() {
  socket_.async_read(incoming_, [self = shared_from_this()](Error error, std::size_t) {
    if (error || !self->socket_.got_text()) return self->close();
    self->hear();
    if (!self->closed_) self->read();
  });
}

void PageSocket::hear() {
  if (!allowance_.take(page_server::Allowance::Clock::now())) return close();
  const beast::flat_buffer::const_buffers_type data = incoming_.data();
  auto said = commands_.read({static_cast<const char*>(data.data()), data.size()});
  incoming_.consume(incoming_.size());
  if (const Refused* const refused = std::get_if<Refused>(&said)) {
    return say(std::make_shared<const std::string>(refused_text(refused->text)));
  }
  Command& command = std::get<Command>(said);
  if (const Ping* const ping = std::get_if<Ping>(&command)) {
    return say(std::make_shared<const std::string>(pong_text(ping->time)));
  }
  if (const Want* const want = std::get_if<Want>(&command)) {
    overlays_ = want->overlays;
    return host_.wants_changed();
  }
  host_.heard(id_, std::move(command));
}

void PageSocket::write() {
  if (writing_ || closed_) return;
  if (!words_.empty()) {
    text_ = std::move(words_.front());
    words_.pop_front();
    socket_.text(true);
    return send(asio::buffer(*text_));
  }
  FrameEncoder& encoder = host_.encoder();
  const std::uint32_t number = encoder.number();
  if (number == 0 || number == sent_) return;
  const bool key = sent_ == 0 || sent_ + 1 != number;
  sent_ = number;
  frame_ = encoder.bytes(key, overlays_);
  host_.sent(key, frame_->size());
  socket_.binary(true);
  send(asio::buffer(*frame_));
}

void PageSocket::send(asio::const_buffer bytes) {
  writing_ = true;
  socket_.async_write(bytes, [self = shared_from_this()](Error error, std::size_t) {
    self->writing_ = false;
    if (error) return self->close();
    self->write();
  });
}

}  // namespace tandem::demos::view
