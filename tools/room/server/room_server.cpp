// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "server/room_server.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "server/request.h"
#include "tandem/pbd/validate.h"
#include "view/access.h"

namespace tandem::room {

namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;

constexpr std::chrono::milliseconds kAcceptAgain{100};

bool is_token(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

/// All private methods run on the server's thread.
class RoomServer::Impl final : public MemberHost, public RequestHost {
 public:
  Impl(const ServerOptions& options, PageFiles files)
      : options_(options), files_(std::move(files)), acceptor_(io_), again_(io_) {
    if (options_.token.empty()) options_.token = demos::view::random_token();
    if (!is_token(options_.token)) {
      pbd::detail::refuse("token", "32 hex digits", options_.token);
    }
    Error error;
    address_ = asio::ip::make_address(options_.address, error);
    if (error) pbd::detail::refuse("address", "numeric", options_.address);
    const Tcp::endpoint endpoint(address_, options_.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw std::runtime_error("cannot listen on " + options_.address + " port " +
                               std::to_string(options_.port) + ": " + error.message());
    }
    port_ = acceptor_.local_endpoint().port();
    accept();
    thread_ = std::thread([this] { io_.run(); });
  }

  ~Impl() override {
    asio::post(io_, [this] { stop(); });
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::uint16_t port() const { return port_; }
  std::string url() const {
    const std::string shown = address_.is_unspecified() ? "127.0.0.1" : address_.to_string();
    const std::string host =
        options_.name.empty()
            ? (address_.is_v6() ? '[' + shown + ']' : shown) + ':' + std::to_string(port_)
            : options_.name;
    return "http://" + host + '/' + options_.token + '/';
  }
  Counters counters() const {
    const std::lock_guard lock(mutex_);
    return counters_;
  }

 private:
  using Room = std::map<std::uint64_t, MemberSocket*>;
  struct Kept {
    std::shared_ptr<MemberSocket> socket;
    asio::ip::address from;
  };

  // RequestHost
  const std::string& token() const override { return options_.token; }
  bool is_own_name(std::string_view host) const override {
    if (!options_.name.empty() && host == options_.name) return true;
    return demos::view::is_name_of(host, address_, port_);
  }
  const PageFile* file(std::string_view path) const override { return files_.find(path); }
  bool may_join(std::string_view room) const override {
    if (std::find(options_.rooms.begin(), options_.rooms.end(), room) == options_.rooms.end())
      return false;
    const auto found = rooms_.find(room);
    return found == rooms_.end() || found->second.size() < options_.max_members;
  }
  void upgrade(std::string room, MemberSocket::Request request, boost::beast::tcp_stream&& stream,
               const asio::ip::address& from) override {
    auto socket =
        std::make_shared<MemberSocket>(*this, std::move(room), options_.member, std::move(stream));
    sockets_[socket.get()] = {socket, from};
    note_address(from, 1);
    socket->start(std::move(request));
    note();
  }
  void refused() override {
    const std::lock_guard lock(mutex_);
    ++counters_.refused;
  }
  void opened(Request& request, const asio::ip::address& from) override {
    requests_[&request] = request.weak_from_this();
    note_address(from, 1);
  }
  void ended(Request& request, const asio::ip::address& from) override {
    requests_.erase(&request);
    note_address(from, -1);
  }

  // MemberHost
  bool join(MemberSocket& socket, std::uint64_t id) override {
    Room& room = rooms_[socket.room()];
    if (room.size() >= options_.max_members || room.contains(id)) return false;
    std::vector<std::uint8_t> welcome{static_cast<std::uint8_t>(Wire::Welcome)};
    const auto came = std::make_shared<const std::vector<std::uint8_t>>(message(Wire::Came, id));
    for (const auto& [other, member] : Room(room)) {
      append_u64(welcome, other);
      member->send(came, true);
    }
    room[id] = &socket;
    socket.send(std::make_shared<const std::vector<std::uint8_t>>(std::move(welcome)), true);
    note();
    return true;
  }
  void relay(MemberSocket& socket, std::uint64_t to, Message message, bool reliable) override {
    {
      const std::lock_guard lock(mutex_);
      ++counters_.relayed;
    }
    const Room& room = rooms_[socket.room()];
    if (to != 0) {
      const auto found = room.find(to);
      if (found != room.end() && found->second != &socket)
        found->second->send(std::move(message), reliable);
      return;
    }
    for (const auto& [other, member] : Room(room)) {
      if (member != &socket) member->send(message, reliable);
    }
  }
  std::int64_t now() const override {
    using namespace std::chrono;
    return begin_ + duration_cast<nanoseconds>(steady_clock::now() - steady_).count();
  }
  void dropped() override {
    const std::lock_guard lock(mutex_);
    ++counters_.dropped;
  }
  void gone(MemberSocket& socket) override {
    const auto room = rooms_.find(socket.room());
    if (room != rooms_.end()) {
      const auto place = room->second.find(socket.id());
      if (place != room->second.end() && place->second == &socket) {
        room->second.erase(place);
        const auto left =
            std::make_shared<const std::vector<std::uint8_t>>(message(Wire::Gone, socket.id()));
        for (const auto& [other, member] : Room(room->second)) member->send(left, true);
      }
      if (room->second.empty()) rooms_.erase(room);
    }
    const auto kept = sockets_.find(&socket);
    if (kept != sockets_.end()) {
      note_address(kept->second.from, -1);
      sockets_.erase(kept);
    }
    note();
  }

  void stop() {
    stopping_ = true;
    Error ignored;
    acceptor_.close(ignored);
    again_.cancel();
    for (const auto& [raw, kept] : std::map(sockets_)) raw->close();
    for (const auto& [request, weak] : std::map(requests_)) {
      if (const auto alive = weak.lock()) alive->close();
    }
  }

  void accept() {
    acceptor_.async_accept([this](Error error, Tcp::socket socket) {
      if (stopping_ || error == asio::error::operation_aborted) return;
      if (error) {
        // Out of descriptors, as a rule: not again at once.
        again_.expires_after(kAcceptAgain);
        return again_.async_wait([this](Error) {
          if (!stopping_) accept();
        });
      }
      Error unknown;
      const asio::ip::address from = socket.remote_endpoint(unknown).address();
      if (!unknown && has_room_for(from)) {
        Error ignored;
        socket.set_option(Tcp::no_delay(true), ignored);
        std::make_shared<Request>(*this, std::move(socket), from)->start();
      } else {
        refused();
      }
      accept();
    });
  }

  bool has_room_for(const asio::ip::address& from) const {
    if (requests_.size() + sockets_.size() >= options_.max_connections) return false;
    const auto found = addresses_.find(from);
    return from.is_loopback() || found == addresses_.end() ||
           found->second < options_.max_per_address;
  }

  void note_address(const asio::ip::address& from, int change) {
    const auto at = addresses_.emplace(from, 0).first;
    at->second += static_cast<std::size_t>(change);
    if (at->second == 0) addresses_.erase(at);
  }

  void note() {
    std::size_t members = 0;
    for (const auto& [name, room] : rooms_) members += room.size();
    const std::lock_guard lock(mutex_);
    counters_.members = members;
    counters_.connections = sockets_.size();
  }

  ServerOptions options_;
  PageFiles files_;
  std::map<Request*, std::weak_ptr<Request>> requests_;
  std::map<asio::ip::address, std::size_t> addresses_;
  std::map<std::string, Room, std::less<>> rooms_;
  asio::io_context io_{1};  // after what connections use when they end
  std::map<MemberSocket*, Kept> sockets_;
  Tcp::acceptor acceptor_;
  asio::steady_timer again_;
  asio::ip::address address_;
  std::uint16_t port_ = 0;
  bool stopping_ = false;
  std::chrono::steady_clock::time_point steady_ = std::chrono::steady_clock::now();
  std::int64_t begin_ = std::chrono::duration_cast<std::chrono::nanoseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count();
  mutable std::mutex mutex_;
  Counters counters_;  // under mutex_
  std::thread thread_;
};

RoomServer::RoomServer(const ServerOptions& options, PageFiles files)
    : impl_(std::make_unique<Impl>(options, std::move(files))) {}
RoomServer::~RoomServer() = default;
std::uint16_t RoomServer::port() const { return impl_->port(); }
std::string RoomServer::url() const { return impl_->url(); }
RoomServer::Counters RoomServer::counters() const { return impl_->counters(); }

}  // namespace tandem::room
