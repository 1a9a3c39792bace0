// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_dialler.h"

#include <algorithm>
#include <asio/connect.hpp>
#include <chrono>
#include <utility>

#include "loopback.h"

namespace tandem::net {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::uint64_t kHearsayAttempts = 10;

asio::ip::address from_bytes(const std::array<std::uint8_t, 16>& ip) {
  const asio::ip::address_v6 v6(asio::ip::address_v6::bytes_type{
      ip[0], ip[1], ip[2], ip[3], ip[4], ip[5], ip[6], ip[7], ip[8], ip[9], ip[10], ip[11], ip[12],
      ip[13], ip[14], ip[15]});
  if (v6.is_v4_mapped()) return asio::ip::make_address_v4(asio::ip::v4_mapped, v6);
  return v6;
}

/// A socket that dials a free port of its own host may get that very port as its source, and TCP
/// then connects it to itself. It is closed without TIME_WAIT, so that a listener may use the port.
bool is_joined_to_itself(asio::ip::tcp::socket& socket) {
  std::error_code error;
  const auto here = socket.local_endpoint(error);
  if (error) return false;
  const auto there = socket.remote_endpoint(error);
  if (error || here != there) return false;
  socket.set_option(asio::socket_base::linger(true, 0), error);
  return true;
}

}  // namespace

TcpDialler::TcpDialler(asio::io_context& context, const TcpOptions& options, bool anywhere,
                       const PeerTable& table, TcpReport& report, Hooks hooks)
    : options_(options),
      anywhere_(anywhere),
      table_(table),
      report_(report),
      hooks_(std::move(hooks)),
      resolver_(context),
      jitter_(options.self) {
  for (const HostPort& address : options_.connect) add(address, 0, true, SteadyClock::now());
  publish();
}

void TcpDialler::add(const HostPort& address, PeerId peer, bool lasting, SteadyTime due) {
  const bool known = std::ranges::any_of(dials_, [&](const Dial& dial) {
    return dial.address == address && (dial.peer == peer || dial.peer == 0 || peer == 0);
  });
  if (known) return;
  if (dials_.size() >= options_.connect.size() + 2 * options_.max_peers) {
    // Hearsay, which one peer can produce in any amount, makes room for first-hand addresses.
    const auto hearsay =
        std::ranges::find_if(dials_, [](const Dial& dial) { return !dial.lasting && !dial.busy; });
    if (!lasting || hearsay == dials_.end()) return;
    dials_.erase(hearsay);
  }
  dials_.push_back({.serial = next_serial_++,
                    .address = address,
                    .lasting = lasting,
                    .peer = peer,
                    .due = due,
                    .reason = {}});
}

void TcpDialler::sweep(SteadyTime now) {
  const std::size_t before = dials_.size();
  std::erase_if(dials_, [](const Dial& dial) {
    return !dial.busy && !dial.lasting && dial.attempts >= kHearsayAttempts;
  });
  bool changed = dials_.size() != before;
  for (std::size_t i = 0; i < dials_.size(); ++i) {
    if (now < dials_[i].due || !may_dial(dials_[i])) continue;
    start(dials_[i]);
    changed = true;
  }
  if (changed) publish();
}

bool TcpDialler::may_dial(const Dial& dial) const {
  if (dial.busy || dial.is_self) return false;
  if (dial.peer == 0) return true;
  if (!table_.wanted(dial.peer)) return false;
  return std::ranges::none_of(
      dials_, [&](const Dial& other) { return other.busy && other.peer == dial.peer; });
}

bool TcpDialler::may_reach(const asio::ip::address& address) const {
  return anywhere_ || is_loopback(address);
}

void TcpDialler::start(Dial& dial) {
  dial.busy = true;
  ++dial.attempts;
  std::error_code not_numeric;
  const asio::ip::address address = asio::ip::make_address(dial.address.host, not_numeric);
  if (not_numeric) {
    look_up(dial);
  } else {
    connect(dial, {Endpoint(address, dial.address.port)});
  }
}

void TcpDialler::look_up(const Dial& dial) {
  resolver_.async_resolve(
      dial.address.host, std::to_string(dial.address.port),
      [this, serial = dial.serial](const std::error_code& error,
                                   const asio::ip::tcp::resolver::results_type& results) {
        const Dial* found = find(serial);
        if (found == nullptr) return;
        if (error) return on_failure(serial, "cannot look up the host: " + error.message());
        std::vector<Endpoint> endpoints;
        for (const auto& result : results) {
          if (may_reach(result.endpoint().address())) endpoints.push_back(result.endpoint());
        }
        if (endpoints.empty()) {
          return on_failure(
              serial, "host is not this machine, and there is neither session_key nor insecure");
        }
        connect(*found, endpoints);
      });
}

void TcpDialler::connect(const Dial& dial, const std::vector<Endpoint>& endpoints) {
  const auto link = hooks_.open(dial.serial);
  asio::async_connect(link->socket(), endpoints,
                      [this, link](const std::error_code& error, const Endpoint&) {
                        if (link->phase == TcpLink::Phase::Closed) return;
                        if (error) return link->close("cannot connect: " + error.message());
                        if (is_joined_to_itself(link->socket())) {
                          return link->close("cannot connect: nobody listens");
                        }
                        hooks_.connected(*link);
                      });
}

void TcpDialler::on_failure(std::uint64_t serial, const std::string& reason) {
  Dial* dial = find(serial);
  if (dial == nullptr) return;
  dial->busy = false;
  dial->reason = reason;
  dial->due = SteadyClock::now() + backoff(dial->attempts);
  publish();
}

void TcpDialler::redial(PeerId peer, bool lasted) {
  for (Dial& dial : dials_) {
    if (dial.peer != peer) continue;
    if (lasted) dial.attempts = 0;
    dial.due = SteadyClock::now() + backoff(dial.attempts);
  }
}

void TcpDialler::learn(std::uint64_t serial, PeerId peer, const HostPort& address) {
  if (Dial* dial = find(serial)) {
    dial->peer = peer;
    dial->lasting = true;
    dial->reason.clear();
  }
  if (address.port == 0) return;
  std::erase_if(dials_, [&](const Dial& dial) {  // the address before a restart
    const bool given = std::ranges::find(options_.connect, dial.address) != options_.connect.end();
    return dial.peer == peer && !dial.busy && !given && dial.address.port != address.port;
  });
  bool known = false;
  for (Dial& dial : dials_) {
    if (dial.peer == 0 && dial.address == address) dial.peer = peer;
    if (dial.peer != peer || dial.address.port != address.port) continue;
    dial.lasting = true;
    known = true;
  }
  if (!known) add(address, peer, true, SteadyClock::now());
}

void TcpDialler::hear(std::span<const PeerAddress> addresses, const asio::ip::address& teller) {
  for (const PeerAddress& entry : addresses) {
    if (entry.peer == 0 || entry.peer == options_.self || entry.port == 0) continue;
    asio::ip::address ip = from_bytes(entry.ip);
    // On the teller's host: the address at which we see the teller.
    if (ip.is_loopback()) ip = teller;
    if (ip.is_unspecified() || ip.is_multicast() || !may_reach(ip)) continue;
    // One of the two dials at once; the other waits in case that fails.
    const bool first = options_.self > entry.peer;
    const auto wait = first ? SteadyTime::duration(0) : 2 * options_.backoff_min;
    add({ip.to_string(), entry.port}, entry.peer, false, SteadyClock::now() + wait);
  }
  publish();
}

void TcpDialler::note_self(std::uint64_t serial) {
  if (Dial* dial = find(serial)) dial->is_self = true;
}

std::uint64_t TcpDialler::attempts_before(std::uint64_t serial) const {
  const auto at = std::ranges::find(dials_, serial, &Dial::serial);
  return at != dials_.end() && at->attempts > 0 ? at->attempts - 1 : 0;
}

/// Doubles from backoff_min to backoff_max; jitter subtracts up to half, so that peers which lost
/// each other at one moment do not redial in lockstep.
SteadyTime::duration TcpDialler::backoff(std::uint64_t attempts) {
  SteadyTime::duration wait = options_.backoff_min;
  for (std::uint64_t i = 1; i < attempts && wait < options_.backoff_max; ++i) wait *= 2;
  wait = std::min<SteadyTime::duration>(wait, options_.backoff_max);
  return wait - wait * static_cast<std::int64_t>(jitter_.next() >> 54) / 2048;
}

TcpDialler::Dial* TcpDialler::find(std::uint64_t serial) {
  const auto at = std::ranges::find(dials_, serial, &Dial::serial);
  return at != dials_.end() ? &*at : nullptr;
}

void TcpDialler::publish() {
  std::vector<DialStatus> out;
  out.reserve(dials_.size());
  for (const Dial& dial : dials_) {
    out.push_back({.address = dial.address,
                   .peer = dial.peer,
                   .connected = false,  // known to the table
                   .attempts = dial.attempts,
                   .reason = dial.reason});
  }
  report_.set_dials(std::move(out));
}

}  // namespace tandem::net
