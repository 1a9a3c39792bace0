// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_mesh.h"

#include <algorithm>
#include <asio/post.hpp>
#include <exception>
#include <utility>

#include "loopback.h"
#include "places.h"

namespace tandem::net {

using std::chrono::milliseconds;

namespace {

constexpr milliseconds kSweepInterval{10};
constexpr milliseconds kExpelInterval{250};
constexpr std::size_t kMaxGreeting = 32;         // inbound connections that are not peers yet
constexpr std::ptrdiff_t kMaxGreetingOfKey = 8;  // of them, of one key
constexpr std::size_t kMaxExtraLinks = 64;       // above max_peers, in any phase

}  // namespace

TcpMesh::TcpMesh(const TcpOptions& options, PeerTable& table, TcpReport& report,
                 std::unique_ptr<TcpSecurity> security)
    : options_(options),
      table_(table),
      report_(report),
      security_(std::move(security)),
      listener_(context_, options_, report_, security_.get(),
                {.new_link = [this] { return new_link(); },
                 .accepted = [this](const auto& link) { on_accepted(link); }}),
      dialler_(context_, options_, security_ || options_.insecure, table_, report_,
               {.open = [this](std::uint64_t dial) { return open(dial); },
                .connected = [this](TcpLink& link) { handshake_.start(link); }}),
      handshake_(options_, table_, report_, dialler_, security_.get(), listener_.port()),
      last_sweep_(Clock::now()) {
  arm_sweep();
  thread_ = std::thread([this] { run(); });
}

TcpMesh::~TcpMesh() {
  // Only lack of memory throws here; then it ends without a goodbye.
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

/// The thread has ended: runs the handlers of the last closes, so that none keeps a link.
void TcpMesh::release() {
  for (const auto& [serial, link] : std::exchange(links_, {})) {
    std::error_code ignored;
    link->phase = TcpLink::Phase::Closed;
    link->socket().close(ignored);
  }
  dialler_.cancel();
  context_.restart();
  context_.poll();
}

void TcpMesh::run() {
  for (;;) {
    try {
      context_.run();
      return;
    } catch (const std::exception& fault) {
      // Out of memory at worst. The thread goes on; the link concerned is cut by its deadline.
      report_.count(&StrangerStatus::refused, std::string("internal: ") + fault.what());
      arm_sweep();  // in case the sweep has thrown
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
      const bool lasted = Clock::now() - link->times.attached > options_.backoff_max;
      link->leave(reason, Clock::now() + kLinger);
      dialler_.redial(peer, lasted);
    }
  });
}

void TcpMesh::on_accepted(const std::shared_ptr<TcpLink>& link) {
  make_room();
  links_.emplace(link->serial(), link);
  handshake_.start(*link);
}

/// Closes one unfinished connection if there are too many: idle connections must not keep others
/// out.
void TcpMesh::make_room() {
  std::vector<Asking> keying, greeting;
  for (const auto& [serial, link] : links_) {
    if (link->dial != 0 || link->phase == TcpLink::Phase::Attached) continue;
    auto& where = link->phase == TcpLink::Phase::Keying ? keying : greeting;
    where.push_back({.key = link->keying.remote,
                     .network = network_of({.ip = to_bytes(link->remote), .port = 1}),
                     .opened = static_cast<std::int64_t>(serial),
                     .connection = serial});
  }
  if (keying.size() + greeting.size() < kMaxGreeting &&
      links_.size() < options_.max_peers + kMaxExtraLinks) {
    return;
  }
  // A connection with the session key does not give way to one without, unless its key has many.
  const bool crowded =
      security_ && std::ranges::any_of(greeting, [&](const Asking& each) {
        return std::ranges::count(greeting, each.key, &Asking::key) > kMaxGreetingOfKey;
      });
  const auto& from = keying.empty() || crowded ? greeting : keying;
  if (from.empty()) return;
  const auto link = links_.at(first_to_go(from));
  if (link->phase != TcpLink::Phase::Leaving) {
    report_.count(&StrangerStatus::refused, "too many connections without handshake");
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
  // This process slept: received data is still to be read, and nobody was idle.
  const bool slept = now - last_sweep_ > options_.idle_timeout / 2;
  last_sweep_ = now;

  for (const auto& link : snapshot()) {
    link->resume();
    switch (link->phase) {
      case TcpLink::Phase::Attached:
        if (slept) link->times.heard = now;
        if (now - link->times.heard > options_.idle_timeout) {
          link->close("connection lost: nothing heard for " +
                      std::to_string(options_.idle_timeout.count()) + " ms");
        } else if (now - link->times.sent > link->times.ping_interval) {
          link->times.sent = now;
          link->send(FrameType::Ping, [](pbd::ByteWriter&) {});
        }
        break;
      case TcpLink::Phase::Closed:
        break;
      default:
        if (now < link->deadline) break;
        if (link->dial == 0 && link->phase != TcpLink::Phase::Leaving) {
          report_.count(&StrangerStatus::timed_out, "handshake timed out");
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
    dialler_.sweep(now);
    listener_.sweep(now);
  }
  arm_sweep();
}

void TcpMesh::begin_shutdown() {
  const SteadyTime now = Clock::now();
  shutdown_deadline_ = now + options_.flush_timeout;
  table_.begin_shutdown();
  listener_.close();
  dialler_.clear();
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

std::shared_ptr<TcpLink> TcpMesh::open(std::uint64_t dial) {
  auto link = new_link();
  link->dial = dial;
  link->deadline = Clock::now() + options_.handshake_timeout;
  links_.emplace(link->serial(), link);
  return link;
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
