// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_mesh.h"

#include <algorithm>
#include <array>
#include <asio/ip/v6_only.hpp>
#include <asio/post.hpp>
#include <exception>
#include <system_error>
#include <utility>

#include "loopback.h"

namespace tandem::net {

using std::chrono::milliseconds;

namespace {

constexpr milliseconds kSweepInterval{10};
constexpr milliseconds kExpelInterval{250};
constexpr milliseconds kAcceptPause{100};   // after accept() has failed, as for want of descriptors
constexpr std::size_t kMaxGreeting = 32;    // inbound connections that are not peers yet
constexpr std::size_t kMaxExtraLinks = 64;  // above max_peers, in any phase

}  // namespace

TcpMesh::TcpMesh(const TcpOptions& options, PeerTable& table, std::unique_ptr<TcpSecurity> security)
    : options_(options), table_(table), security_(std::move(security)), jitter_(options.self) {
  if (options_.listen_port) listen();
  for (const HostPort& address : options_.connect) add_dial(address, 0, true, Clock::now());
  publish_dials();
  last_sweep_ = Clock::now();
  arm_sweep();
  thread_ = std::thread([this] { run(); });
}

TcpMesh::~TcpMesh() {
  // Nothing here throws but for want of memory; then it ends without a goodbye.
  try {
    asio::post(context_, [this] { begin_shutdown(); });
  } catch (...) {
    context_.stop();
  }
  thread_.join();
  try {
    release();
  } catch (...) {
    return;  // the context drops what is left
  }
}

/// The thread has ended: runs what its last closes have left, so that no handler keeps a link.
void TcpMesh::release() {
  for (const auto& [serial, link] : std::exchange(links_, {})) {
    std::error_code ignored;
    link->phase = TcpLink::Phase::Closed;
    link->socket().close(ignored);
  }
  resolver_.cancel();
  context_.restart();
  context_.poll();
}

void TcpMesh::listen() {
  std::error_code error;
  const asio::ip::address address = asio::ip::make_address(options_.listen_address, error);
  const Endpoint endpoint(address, *options_.listen_port);
  if (!error) acceptor_.open(endpoint.protocol(), error);
  // A restarted peer must get its port although connections of its predecessor linger.
  if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
  if (!error && address.is_v6()) acceptor_.set_option(asio::ip::v6_only(false), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (!error) acceptor_.non_blocking(true, error);
  if (!error) local_port_ = acceptor_.local_endpoint(error).port();
  if (error) {
    // The library's own category would not compare equal to std::errc.
    throw std::system_error(
        error.value(), std::system_category(),
        "TcpTransport: cannot listen on " +
            to_string(HostPort{options_.listen_address, *options_.listen_port}));
  }
  accept();
}

void TcpMesh::run() {
  for (;;) {
    try {
      context_.run();
      return;
    } catch (const std::exception& fault) {
      // Out of memory at worst. The thread goes on; what was being handled is cut by its deadline.
      table_.count(PeerTable::Stranger::Refused, std::string("internal: ") + fault.what());
      arm_sweep();  // it may have been the sweep
    }
  }
}

void TcpMesh::wake(PeerId peer) {
  asio::post(context_, [this, peer] {
    if (TcpLink* link = find_link(table_.link_of(peer))) link->kick();
  });
}

void TcpMesh::cut(std::uint64_t serial, const std::string& reason) {
  asio::post(context_, [this, serial, reason] {
    if (TcpLink* link = find_link(serial)) {
      const PeerId peer = link->hello.peer;
      const bool lasted = Clock::now() - link->attached_at > options_.backoff_max;
      link->leave(reason, Clock::now() + kLinger);
      redial_peer(peer, lasted);
    }
  });
}

void TcpMesh::accept() {
  const auto link = new_link();
  acceptor_.async_accept(link->socket(), [this, link](const std::error_code& error) {
    if (!acceptor_.is_open()) return;
    on_accept(link, error);
  });
}

void TcpMesh::on_accept(const std::shared_ptr<TcpLink>& link, const std::error_code& error) {
  if (error) {
    accept_again_ = Clock::now() + kAcceptPause;
    return;
  }
  table_.count(PeerTable::Stranger::Accepted);
  if (over_rate(*link)) {
    table_.count(PeerTable::Stranger::Limited, "too many connections from one address");
    return accept();  // which lets go of this one
  }
  make_room();
  links_.emplace(link->serial(), link);
  link->phase = security_ ? TcpLink::Phase::Keying : TcpLink::Phase::Greeting;
  link->deadline = Clock::now() + options_.handshake_timeout;
  link->start(options_.socket_buffer_bytes);
  accept();
}

/// Nothing is known of whoever has just connected but his address.
bool TcpMesh::over_rate(TcpLink& link) const {
  if (!security_) return false;
  std::error_code error;
  const asio::ip::address from = plain(link.socket().remote_endpoint(error).address());
  if (error) return false;  // he has gone again, which link.start() will find
  const asio::ip::address_v6 v6 =
      from.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, from.to_v4()) : from.to_v6();
  std::array<std::uint8_t, 16> ip{};
  std::ranges::copy(v6.to_bytes(), ip.begin());
  return !security_->allow(ip, nanoseconds(Clock::now()));
}

/// Closes the oldest of those that are no peers yet where there are too many: whoever opens
/// connections and says nothing must not keep others out.
void TcpMesh::make_room() {
  const auto is_stranger = [](const auto& entry) {
    const TcpLink& link = *entry.second;
    return link.dial == 0 && link.phase != TcpLink::Phase::Attached;
  };
  const auto strangers = static_cast<std::size_t>(std::ranges::count_if(links_, is_stranger));
  if (strangers < kMaxGreeting && links_.size() < options_.max_peers + kMaxExtraLinks) return;
  // Whoever has the session key does not give way to those who may not have it.
  auto oldest = std::ranges::find_if(links_, [](const auto& entry) {
    return entry.second->dial == 0 && entry.second->phase == TcpLink::Phase::Keying;
  });
  if (oldest == links_.end()) oldest = std::ranges::find_if(links_, is_stranger);
  if (oldest == links_.end()) return;
  const auto link = oldest->second;
  if (link->phase != TcpLink::Phase::Leaving) {
    table_.count(PeerTable::Stranger::Refused, "too many connections without handshake");
  }
  link->close("too many connections without handshake");
}

void TcpMesh::arm_sweep() {
  sweep_timer_.expires_after(kSweepInterval);
  sweep_timer_.async_wait([this](const std::error_code& error) {
    if (!error) sweep();
  });
}

void TcpMesh::sweep() {
  const SteadyTime now = Clock::now();
  // This process slept: what came meanwhile is still to be read, nobody was idle.
  const bool slept = now - last_sweep_ > options_.idle_timeout / 2;
  last_sweep_ = now;

  for (const auto& link : snapshot()) {
    link->resume();
    switch (link->phase) {
      case TcpLink::Phase::Attached:
        if (slept) link->last_heard = now;
        if (now - link->last_heard > options_.idle_timeout) {
          link->close("connection lost: nothing heard for " +
                      std::to_string(options_.idle_timeout.count()) + " ms");
        } else if (now - link->last_sent > link->ping_interval) {
          link->last_sent = now;
          link->send(FrameType::Ping, [](pbd::ByteWriter&) {});
        }
        break;
      case TcpLink::Phase::Closed:
        break;
      default:
        if (now < link->deadline) break;
        if (link->dial == 0 && link->phase != TcpLink::Phase::Leaving) {
          table_.count(PeerTable::Stranger::TimedOut, "handshake timed out");
        }
        link->close(link->phase == TcpLink::Phase::Connecting ? "connecting timed out"
                                                              : "handshake timed out");
    }
  }
  if (security_ && now >= next_expel_) {
    next_expel_ = now + kExpelInterval;
    expel();
  }
  if (shutdown_deadline_) {
    if (links_.empty() || now >= *shutdown_deadline_) {
      context_.stop();
      return;
    }
  } else {
    sweep_dials(now);
    if (accept_again_ != SteadyTime{} && now >= accept_again_) {
      accept_again_ = {};
      accept();
    }
  }
  arm_sweep();
}

void TcpMesh::begin_shutdown() {
  const SteadyTime now = Clock::now();
  shutdown_deadline_ = now + options_.flush_timeout;
  table_.begin_shutdown();
  std::error_code ignored;
  acceptor_.close(ignored);
  dials_.clear();
  for (const auto& link : snapshot()) {
    if (link->phase == TcpLink::Phase::Attached) {
      link->leave("has left", *shutdown_deadline_);
    } else if (link->phase != TcpLink::Phase::Leaving) {
      link->close("closed");
    }
  }
  if (links_.empty()) context_.stop();
}

std::shared_ptr<TcpLink> TcpMesh::new_link() {
  return std::make_shared<TcpLink>(context_, static_cast<TcpLinkOwner&>(*this), next_serial_++,
                                   security_ ? kMaxKeyFrame : kMaxControlFrame);
}

std::vector<std::shared_ptr<TcpLink>> TcpMesh::snapshot() const {
  std::vector<std::shared_ptr<TcpLink>> links;
  links.reserve(links_.size());
  for (const auto& [serial, link] : links_) links.push_back(link);
  return links;
}

TcpLink* TcpMesh::find_link(std::uint64_t serial) {
  const auto at = links_.find(serial);
  return at != links_.end() ? at->second.get() : nullptr;
}

}  // namespace tandem::net
