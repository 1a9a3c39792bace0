// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "peer_table.h"
#include "tcp_security.h"
#include "wire.h"

namespace tandem::net {

class TcpLink;

constexpr std::size_t kMaxControlBytes = 256 * 1024;  // waiting control frames of one link

/// Callbacks of a link, on the network thread.
class TcpLinkOwner {
 public:
  virtual void on_frame(TcpLink& link, const FrameBuffer::Frame& frame) = 0;
  /// The stream is no sequence of frames.
  virtual void on_malformed(TcpLink& link, const std::string& reason) = 0;
  /// A frame not sealed by the other end.
  virtual void on_forged(TcpLink& link, const std::string& reason) = 0;
  /// Whether more may be read. If not, resume() is called once it may.
  virtual bool may_read(TcpLink& link) = 0;
  /// Append what to send next to `out`, which may stay empty.
  virtual void on_writable(TcpLink& link, std::vector<std::byte>& out) = 0;
  /// Last call for this link.
  virtual void on_closed(TcpLink& link, const std::string& reason) = 0;

 protected:
  ~TcpLinkOwner() = default;
};

/// One TCP connection as a stream of frames. Network thread only. Pending operations keep the
/// object alive; after close() they have no effect.
class TcpLink : public std::enable_shared_from_this<TcpLink> {
 public:
  enum class Phase {
    Connecting,  // outbound, no connection yet
    Keying,      // with a session key: waiting for the other half of the key exchange
    Greeting,    // waiting for the other's Hello
    Welcoming,   // Hellos were accepted, waiting for Welcome
    Attached,    // carries a peer's frames
    Leaving,     // Goodbye queued or sent; only reads until the other end closes
    Closed,
  };

  /// @param max_payload  of a frame, until raise_limit()
  TcpLink(asio::io_context& context, TcpLinkOwner& owner, std::uint64_t serial,
          std::size_t max_payload)
      : socket_(context), owner_(owner), serial_(serial), input_(max_payload) {}

  asio::ip::tcp::socket& socket() { return socket_; }
  std::uint64_t serial() const { return serial_; }

  /// The socket is connected: set its options and read. `send_buffer` in bytes.
  void start(std::size_t send_buffer);
  void raise_limit(std::size_t max_payload) {
    input_.raise_limit(max_payload + (cipher_ ? kSealBytes : 0));
  }
  /// Everything read and written from here on is sealed.
  void protect(std::unique_ptr<LinkCipher> cipher);

  /// Queues a control frame and sends it after the frames before it.
  template <class Fill>
  void send(FrameType type, Fill&& fill) {
    if (phase == Phase::Leaving || phase == Phase::Closed) return;
    if (output_.control.size() > kMaxControlBytes) return close("connection lost: does not read");
    append_frame(output_.control, type, std::forward<Fill>(fill));
    kick();
  }

  /// Continues reading after may_read() has stopped it.
  void resume();
  /// There may be something to write.
  void kick();
  /// Send what is queued, a Goodbye with `reason`, and close once the other end has closed.
  void leave(const std::string& reason, SteadyTime deadline);
  void close(const std::string& reason);

  // State of the owner's protocol, per link.
  Phase phase = Phase::Connecting;
  std::uint64_t dial = 0;  // 0: inbound
  struct Keying {
    std::unique_ptr<KeyExchange> exchange;  // of the dialler, until the exchange has ended
    Key remote{};                           // set by the exchange
    std::vector<std::byte> badge;           // set by the exchange
  };
  Keying keying;
  Member member{.bound = true};  // once its Hello was accepted
  Hello hello;                   // the other's; peer 0 until it has come
  std::uint64_t ticket = 0;
  std::string failure;  // why it is leaving, for the dialler
  asio::ip::address remote;
  SteadyTime deadline{};  // of every phase but Attached
  struct Times {
    SteadyTime attached{};
    SteadyTime heard{};  // last
    SteadyTime sent{};   // last
    std::chrono::milliseconds ping_interval{};
  };
  Times times;
  bool ack_due = false;

 private:
  struct Output {
    std::vector<std::byte> control;  // frames to send before all others
    std::vector<std::byte> written;  // being written
    std::vector<std::byte> sealed;   // swapped with `written`
    bool writing = false;
  };

  void read();
  void on_read(const std::error_code& error, std::size_t count);
  void take_frames();

  asio::ip::tcp::socket socket_;
  TcpLinkOwner& owner_;
  const std::uint64_t serial_;
  FrameBuffer input_;
  Output output_;
  std::unique_ptr<LinkCipher> cipher_;
  bool paused_ = false;
  std::optional<std::string> goodbye_;
};

}  // namespace tandem::net
