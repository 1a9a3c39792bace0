// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/catch.h"
#include "support/eventually.h"
#include "support/sockets.h"
#include "tandem/net/tcp.h"

/// A peer made of a plain socket, with an encoding of its own: the wire format as bytes.
namespace raw {

using Bytes = std::vector<std::byte>;

constexpr std::uint8_t kHello = 1;
constexpr std::uint8_t kWelcome = 2;
constexpr std::uint8_t kGoodbye = 3;
constexpr std::uint8_t kAddresses = 4;
constexpr std::uint8_t kPing = 5;
constexpr std::uint8_t kAck = 6;
constexpr std::uint8_t kNewest = 7;
constexpr std::uint8_t kReliable = 8;

using tandem::testing::eventually;

inline Bytes le(std::uint64_t value, int count) {
  Bytes out;
  for (int i = 0; i < count; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
  return out;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Bytes text(const std::string& characters) {
  Bytes out;
  for (const char c : characters) out.push_back(static_cast<std::byte>(c));
  return out;
}

inline std::string as_text(const Bytes& bytes) {
  std::string out;
  for (const std::byte b : bytes) out += static_cast<char>(b);
  return out;
}

inline std::uint64_t number(std::span<const std::byte> bytes) {
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    out |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  }
  return out;
}

inline Bytes frame(std::uint8_t type, const Bytes& payload) {
  return le(1 + payload.size(), 4) + le(type, 1) + payload;
}

struct Greeting {
  std::uint64_t peer = 0;
  std::uint64_t incarnation = 1;
  std::uint64_t scene = 0;
  std::uint16_t version = 1;
  std::uint32_t max_frame = 65536;
  std::uint32_t idle_ms = 60000;
  std::uint16_t port = 0;
};

inline Bytes hello(const Greeting& g) {
  return frame(kHello, text("TNDM") + le(g.version, 2) + le(g.peer, 8) + le(g.incarnation, 8) +
                           le(g.scene, 8) + le(g.max_frame, 4) + le(g.idle_ms, 4) + le(g.port, 2));
}

inline Bytes welcome(std::uint64_t ticket, std::uint64_t received) {
  return frame(kWelcome, le(ticket, 8) + le(received, 8));
}

struct Frame {
  std::uint8_t type = 0;
  Bytes payload;
};

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) { REQUIRE(fd_ >= 0); }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Socket() { close(); }

  /// @param from  a loopback address, host byte order
  static Socket connect(std::uint16_t port, int receive_buffer = 0,
                        std::uint32_t from = INADDR_LOOPBACK) {
    Socket out(static_cast<int>(::socket(AF_INET, SOCK_STREAM, 0)));
    const int on = 1;
    ::setsockopt(out.fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (receive_buffer > 0) {
      ::setsockopt(out.fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    }
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(from);
    REQUIRE(::bind(out.fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(out.fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
    return out;
  }

  void close() {
    if (fd_ >= 0) tandem::testing::close_socket(std::exchange(fd_, -1));
  }

  /// As when the process is killed with bytes on the way: the other end sees a reset.
  void reset() {
    linger now{};
    now.l_onoff = 1;
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    close();
  }

  /// False where the other end has closed.
  bool send(const Bytes& bytes) {
    std::size_t at = 0;
    while (at < bytes.size()) {
      const ssize_t n = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (n <= 0) return false;
      at += static_cast<std::size_t>(n);
    }
    return true;
  }

  /// The next frame; none where the stream has ended.
  std::optional<Frame> read() {
    const auto head = read_bytes(4);
    if (!head) return {};
    const auto body = read_bytes(number(*head));
    if (!body || body->empty()) return {};
    return Frame{std::to_integer<std::uint8_t>(body->front()), {body->begin() + 1, body->end()}};
  }

  /// The next frame of that type; others are skipped.
  std::optional<Frame> read(std::uint8_t type) {
    auto next = read();
    while (next && next->type != type) next = read();
    return next;
  }

  /// Reads up to the end of the stream; false where it does not end.
  bool ends() {
    std::byte sink[4096];
    for (;;) {
      if (!readable(20000)) return false;
      if (::recv(fd_, sink, sizeof sink, 0) <= 0) return true;
    }
  }

  bool readable(int timeout_ms) const {
    pollfd poll{.fd = fd_, .events = POLLIN, .revents = 0};
    return ::poll(&poll, 1, timeout_ms) > 0;
  }

 protected:
  int fd_;

 private:
  std::optional<Bytes> read_bytes(std::size_t count) {
    Bytes out(count);
    std::size_t at = 0;
    while (at < count) {
      if (!readable(20000)) FAIL("nothing came");
      const ssize_t n = ::recv(fd_, out.data() + at, count - at, 0);
      if (n <= 0) return {};
      at += static_cast<std::size_t>(n);
    }
    return out;
  }
};

/// Listens on a free port of the loopback address.
class Listener : public Socket {
 public:
  Listener() : Socket(static_cast<int>(::socket(AF_INET, SOCK_STREAM, 0))) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0);
    REQUIRE(::listen(fd_, 16) == 0);
    socklen_t size = sizeof at;
    REQUIRE(::getsockname(fd_, reinterpret_cast<sockaddr*>(&at), &size) == 0);
    port_ = ntohs(at.sin_port);
  }

  std::uint16_t port() const { return port_; }
  Socket accept() {
    REQUIRE(readable(20000));
    return Socket(static_cast<int>(::accept(fd_, nullptr, nullptr)));
  }

 private:
  std::uint16_t port_ = 0;
};

/// The Welcome the transport has sent, after a full handshake by this socket as the dialler.
struct Joined {
  std::uint64_t ticket = 0;
  std::uint64_t received = 0;
};

inline Joined join(Socket& socket, const Greeting& greeting, std::uint64_t received = 0,
                   std::uint64_t ticket = 1) {
  REQUIRE(socket.send(hello(greeting)));
  const auto their_hello = socket.read(kHello);
  REQUIRE(their_hello);
  const std::uint64_t their_id = number(std::span(their_hello->payload).subspan(6, 8));
  if (greeting.peer < their_id) REQUIRE(socket.send(welcome(ticket, received)));
  const auto theirs = socket.read(kWelcome);
  REQUIRE(theirs);
  const Joined out{number(std::span(theirs->payload).first(8)),
                   number(std::span(theirs->payload).subspan(8, 8))};
  if (greeting.peer > their_id) REQUIRE(socket.send(welcome(out.ticket, received)));
  return out;
}

/// Fails the test where descriptors or threads are left at the end of its scope. On Linux alone.
class LeakCheck {
 public:
#ifdef __linux__
  static constexpr bool kCounts = true;
#else
  static constexpr bool kCounts = false;
#endif
  LeakCheck() : files_(count("/proc/self/fd")), threads_(count("/proc/self/task")) {}
  ~LeakCheck() {
    CHECK(eventually([&] { return count("/proc/self/fd") == files_; }));
    // Not equal: a thread that was joined just before this scope began may have been listed still.
    CHECK(eventually([&] { return count("/proc/self/task") <= threads_; }));
  }

  static std::ptrdiff_t count(const char* folder) {
#ifdef __linux__
    return std::distance(std::filesystem::directory_iterator(folder), {});
#else
    static_cast<void>(folder);
    return 0;
#endif
  }

 private:
  std::ptrdiff_t files_;
  std::ptrdiff_t threads_;
};

/// Options for a listening peer on the loopback address, patient with slow machines, quick to
/// redial.
inline tandem::net::TcpOptions options(tandem::net::PeerId self,
                                       std::vector<std::uint16_t> connect = {}) {
  tandem::net::TcpOptions out;
  out.self = self;
  out.listen_port = 0;
  out.listen_address = "127.0.0.1";
  for (const std::uint16_t port : connect) out.connect.push_back({"127.0.0.1", port});
  out.handshake_timeout = std::chrono::milliseconds(10000);
  out.idle_timeout = std::chrono::milliseconds(10000);
  out.backoff_min = std::chrono::milliseconds(10);
  out.backoff_max = std::chrono::milliseconds(100);
  out.drop_hold = std::chrono::milliseconds(0);
  return out;
}

inline tandem::consensus::PeerStatus status(const tandem::consensus::Transport& transport,
                                            tandem::net::PeerId peer) {
  for (const auto& entry : transport.peers()) {
    if (entry.id == peer) return entry;
  }
  return {};
}

inline bool connected(const tandem::consensus::Transport& transport, tandem::net::PeerId peer) {
  return status(transport, peer).connected;
}

inline bool linked(const tandem::consensus::Transport& a, const tandem::consensus::Transport& b) {
  return connected(a, b.self()) && connected(b, a.self());
}

/// Drains until `count` packets have come; returns all that came.
inline std::vector<tandem::consensus::Packet> receive(tandem::consensus::Transport& transport,
                                                      std::size_t count) {
  std::vector<tandem::consensus::Packet> out;
  CHECK(eventually([&] {
    transport.drain(out);
    return out.size() >= count;
  }));
  return out;
}

}  // namespace raw
