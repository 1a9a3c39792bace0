// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/link.h"

#include <sodium.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace tandem::room {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;
using Socket = websocket::stream<beast::tcp_stream>;

constexpr std::chrono::seconds kAgain{1};
constexpr std::chrono::seconds kPatience{5};
constexpr std::size_t kMaxWaiting = 1 << 20;  // bytes queued for sending
constexpr std::size_t kMaxHeard = 16384;      // unread messages

void require(bool good, const char* rule) {
  if (!good) throw std::invalid_argument(std::string("link must ") + rule);
}

}  // namespace

Address read_address(std::string_view link) {
  constexpr std::string_view kScheme = "http://";
  constexpr std::string_view kRoom = "?room=";
  require(link.substr(0, kScheme.size()) == kScheme, "begin with http://");
  link.remove_prefix(kScheme.size());
  Address address;
  const std::size_t hash = link.find('#');
  require(hash != std::string_view::npos, "end with # and the room's key");
  const std::string_view digits = link.substr(hash + 1);
  address.key.resize(kKeyBytes);
  std::size_t size = 0;
  const char* end = nullptr;
  const bool decoded =
      sodium_base642bin(address.key.data(), address.key.size(), digits.data(), digits.size(),
                        nullptr, &size, &end, sodium_base64_VARIANT_URLSAFE_NO_PADDING) == 0;
  require(decoded && size == kKeyBytes && end == digits.data() + digits.size(),
          "have a key of 43 letters after #");
  link = link.substr(0, hash);
  const std::size_t slash = link.find('/');
  require(slash != std::string_view::npos, "have a token after the host");
  const std::string_view host = link.substr(0, slash);
  link.remove_prefix(slash + 1);
  const std::size_t second = link.find('/');
  require(second == 32, "have a token of 32 digits after the host");
  address.token = link.substr(0, second);
  link.remove_prefix(second + 1);
  require(link.empty() || link.substr(0, kRoom.size()) == kRoom, "have ?room=NAME after the token");
  address.room = link.empty() ? "sandbox" : link.substr(kRoom.size());
  const std::size_t colon = host.rfind(':');
  const bool bare = colon == std::string_view::npos || host.back() == ']';
  address.port = bare ? "80" : host.substr(colon + 1);
  address.host = bare ? host : host.substr(0, colon);
  if (address.host.size() > 2 && address.host.front() == '[') {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  require(!address.host.empty(), "name a host");
  return address;
}

/// Private methods run on its thread.
class Link::Impl {
 public:
  Impl(Address address, MemberId self)
      : address_(std::move(address)), self_(self), resolver_(io_), again_(io_) {
    asio::post(io_, [this] { connect(); });
    thread_ = std::thread([this] {
      const auto work = asio::make_work_guard(io_);
      io_.run();
    });
  }
  ~Impl() {
    asio::post(io_, [this] {
      // Allow the last messages to be sent.
      again_.expires_after(std::chrono::milliseconds(waiting_.empty() ? 0 : 200));
      again_.async_wait([this](Error) { io_.stop(); });
    });
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  bool send(Bytes message) {
    if (!connected_ || queued_ + message.size() > kMaxWaiting) return false;
    queued_ += message.size();
    asio::post(io_, [this, message = std::move(message)]() mutable {
      waiting_.push_back(std::move(message));
      write();
    });
    return true;
  }
  void take(std::vector<Bytes>& out) {
    const std::lock_guard lock(mutex_);
    std::move(heard_.begin(), heard_.end(), std::back_inserter(out));
    heard_.clear();
  }
  bool connected() const { return connected_; }

 private:
  void connect() {
    resolver_.async_resolve(address_.host, address_.port,
                            [this](Error error, const Tcp::resolver::results_type& ends) {
                              if (error) return retry();
                              socket_.emplace(io_);
                              beast::get_lowest_layer(*socket_).expires_after(kPatience);
                              beast::get_lowest_layer(*socket_).async_connect(
                                  ends, [this](Error failed, const Tcp::endpoint&) {
                                    if (failed) return retry();
                                    shake_hands();
                                  });
                            });
  }
  void shake_hands() {
    beast::get_lowest_layer(*socket_).expires_never();
    beast::get_lowest_layer(*socket_).socket().set_option(Tcp::no_delay(true));
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::client);
    timeout.idle_timeout = std::chrono::seconds(15);
    timeout.keep_alive_pings = true;
    socket_->set_option(timeout);
    socket_->read_message_max(kMaxWireBytes + kWireHeader);
    socket_->binary(true);
    const bool v6 = address_.host.find(':') != std::string::npos;
    const std::string host = (v6 ? '[' + address_.host + ']' : address_.host) + ':' + address_.port;
    socket_->async_handshake(host, '/' + address_.token + "/socket/" + address_.room,
                             [this](Error error) {
                               if (error) return retry();
                               waiting_.assign(1, message(Wire::Join, self_));
                               queued_ = waiting_.front().size();
                               incoming_.consume(incoming_.size());
                               connected_ = true;
                               hear({});
                               write();
                               read();
                             });
  }
  void read() {
    socket_->async_read(incoming_, [this](Error error, std::size_t) {
      if (error) return retry();
      const auto data = incoming_.data();
      const auto* const first = static_cast<const std::uint8_t*>(data.data());
      if (socket_->got_binary() && data.size() > 0) hear(Bytes(first, first + data.size()));
      incoming_.consume(incoming_.size());
      read();
    });
  }
  void hear(Bytes message) {
    const std::lock_guard lock(mutex_);
    if (heard_.size() >= kMaxHeard) heard_.pop_front();
    heard_.push_back(std::move(message));
  }
  void write() {
    if (writing_ || waiting_.empty() || !connected_) return;
    writing_ = true;
    socket_->async_write(asio::buffer(waiting_.front()), [this](Error error, std::size_t) {
      writing_ = false;
      if (waiting_.empty()) return;
      queued_ -= std::min<std::size_t>(queued_, waiting_.front().size());
      waiting_.pop_front();
      if (!error) write();
    });
  }
  void retry() {
    connected_ = false;
    waiting_.clear();
    queued_ = 0;
    again_.expires_after(kAgain);
    again_.async_wait([this](Error error) {
      if (!error) connect();
    });
  }

  Address address_;
  MemberId self_;
  asio::io_context io_{1};
  Tcp::resolver resolver_;
  asio::steady_timer again_;
  std::optional<Socket> socket_;
  beast::flat_buffer incoming_{kMaxWireBytes + kWireHeader};
  std::deque<Bytes> waiting_;
  bool writing_ = false;
  std::atomic<bool> connected_ = false;
  std::atomic<std::size_t> queued_ = 0;
  std::mutex mutex_;
  std::deque<Bytes> heard_;  // under mutex_
  std::thread thread_;
};

Link::Link(const Address& address, MemberId self) : impl_(std::make_unique<Impl>(address, self)) {}
Link::~Link() = default;
bool Link::send(Bytes message) { return impl_->send(std::move(message)); }
void Link::take(std::vector<Bytes>& out) { impl_->take(out); }
bool Link::connected() const { return impl_->connected(); }

}  // namespace tandem::room
