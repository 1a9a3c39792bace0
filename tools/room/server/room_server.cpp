// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "server/room_server.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "page_server/page_server.h"

namespace tandem::room {

namespace {

using page_server::File;
using page_server::Place;
using page_server::UpgradeRequest;

/// For visitors with an incomplete link.
constexpr std::string_view kHelp =
    "<p>Somebody has a room here that one enters by a link, which has secrets in it.</p>"
    "<p>Open the whole link as it was sent to you, up to the last letter after <code>#</code>. "
    "Where it is of another day, ask for a new one: it changes whenever the room's program is "
    "started.</p>";

page_server::Options web_options(const ServerOptions& options) {
  page_server::Options web;
  web.address = options.address;
  web.port = options.port;
  web.token = options.token;
  web.name = options.name;
  web.may_have_tls = true;
  web.max_connections = options.max_connections;
  web.max_per_address = options.max_per_address;
  web.scripts = "'self' 'wasm-unsafe-eval'";
  web.help = kHelp;
  return web;
}

}  // namespace

/// Private methods run on the server's thread.
class RoomServer::Impl final : public MemberHost, public page_server::Site {
 public:
  Impl(const ServerOptions& options, PageFiles files)
      : options_(options), files_(std::move(files)), web_(web_options(options), *this) {
    web_.start();
  }
  ~Impl() override { web_.stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const page_server::PageServer& web() const { return web_; }
  Counters counters() const {
    const std::lock_guard lock(mutex_);
    Counters result = counters_;
    result.refused = web_.refused();
    return result;
  }

 private:
  using Room = std::map<std::uint64_t, MemberSocket*>;
  struct Kept {
    std::shared_ptr<MemberSocket> socket;
    Place place;
  };

  // Site
  std::optional<File> file(std::string_view path) const override {
    const PageFile* const found = files_.find(path);
    if (found == nullptr) return std::nullopt;
    return File{found->mime, found->bytes, true};
  }
  bool has_room(std::string_view path) const override {
    const std::string_view name = room_of(path);
    if (std::find(options_.rooms.begin(), options_.rooms.end(), name) == options_.rooms.end())
      return false;
    const auto found = rooms_.find(name);
    return found == rooms_.end() || found->second.size() < options_.max_members;
  }
  void upgrade(std::string_view path, UpgradeRequest request, boost::beast::tcp_stream&& stream,
               Place place) override {
    auto socket = std::make_shared<MemberSocket>(*this, std::string(room_of(path)), options_.member,
                                                 std::move(stream));
    sockets_[socket.get()] = {socket, std::move(place)};
    socket->start(std::move(request));
    note();
  }
  void end() override {
    for (const auto& [raw, kept] : std::map(sockets_)) raw->close();
  }
  /// The part after the slash; "" if there is none.
  static std::string_view room_of(std::string_view path) {
    return path.substr(0, 1) == "/" ? path.substr(1) : std::string_view();
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
    sockets_.erase(&socket);
    note();
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
  std::map<std::string, Room, std::less<>> rooms_;
  page_server::PageServer web_;
  std::map<MemberSocket*, Kept> sockets_;  // destroyed before the server, whose thread uses them
  std::chrono::steady_clock::time_point steady_ = std::chrono::steady_clock::now();
  std::int64_t begin_ = std::chrono::duration_cast<std::chrono::nanoseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count();
  mutable std::mutex mutex_;
  Counters counters_;  // under mutex_
};

RoomServer::RoomServer(const ServerOptions& options, PageFiles files)
    : impl_(std::make_unique<Impl>(options, std::move(files))) {}
RoomServer::~RoomServer() = default;
std::uint16_t RoomServer::port() const { return impl_->web().port(); }
std::string RoomServer::url() const { return impl_->web().url(); }
RoomServer::Counters RoomServer::counters() const { return impl_->counters(); }

}  // namespace tandem::room
