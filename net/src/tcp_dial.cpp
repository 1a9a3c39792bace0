// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// TcpMesh: which addresses to dial, when, and how others learn of them.
#include <algorithm>
#include <asio/connect.hpp>
#include <utility>

#include "loopback.h"
#include "tcp_mesh.h"

namespace tandem::net {

namespace {

constexpr std::uint64_t kHearsayAttempts = 10;

asio::ip::address from_bytes(const std::array<std::uint8_t, 16>& ip) {
  const asio::ip::address_v6 v6(asio::ip::address_v6::bytes_type{
      ip[0], ip[1], ip[2], ip[3], ip[4], ip[5], ip[6], ip[7], ip[8], ip[9], ip[10], ip[11], ip[12],
      ip[13], ip[14], ip[15]});
  if (v6.is_v4_mapped()) return asio::ip::make_address_v4(asio::ip::v4_mapped, v6);
  return v6;
}

/// Who dials a port of his own machine where nobody listens may be given that very port to dial
/// from, and TCP then joins the socket to itself. Such a socket is told to leave nothing behind, so
/// that somebody may come to listen there.
bool is_joined_to_itself(asio::ip::tcp::socket& socket) {
  std::error_code error;
  const auto here = socket.local_endpoint(error);
  if (error) return false;
  const auto there = socket.remote_endpoint(error);
  if (error || here != there) return false;
  socket.set_option(asio::socket_base::linger(true, 0), error);
  return true;
}

PeerAddress peer_address_of(const TcpLink& link) {
  const asio::ip::address ip = plain(link.remote);
  const asio::ip::address_v6 v6 =
      ip.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, ip.to_v4()) : ip.to_v6();
  PeerAddress out{.peer = link.hello.peer, .ip = {}, .port = link.hello.listen_port};
  std::ranges::copy(v6.to_bytes(), out.ip.begin());
  return out;
}

}  // namespace

void TcpMesh::add_dial(const HostPort& address, PeerId peer, bool lasting, SteadyTime due) {
  const bool known = std::ranges::any_of(dials_, [&](const Dial& dial) {
    return dial.address == address && (dial.peer == peer || dial.peer == 0 || peer == 0);
  });
  if (known) return;
  if (dials_.size() >= options_.connect.size() + 2 * options_.max_peers) {
    // Hearsay, of which one peer can tell any amount, makes room for what is known first-hand.
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

void TcpMesh::sweep_dials(SteadyTime now) {
  const std::size_t before = dials_.size();
  std::erase_if(dials_, [](const Dial& dial) {
    return !dial.busy && !dial.lasting && dial.attempts >= kHearsayAttempts;
  });
  bool changed = dials_.size() != before;
  for (std::size_t i = 0; i < dials_.size(); ++i) {
    if (now < dials_[i].due || !may_dial(dials_[i])) continue;
    start_dial(dials_[i]);
    changed = true;
  }
  if (changed) publish_dials();
}

bool TcpMesh::may_dial(const Dial& dial) const {
  if (dial.busy || dial.is_self) return false;
  if (dial.peer == 0) return true;
  if (!table_.wanted(dial.peer)) return false;
  return std::ranges::none_of(
      dials_, [&](const Dial& other) { return other.busy && other.peer == dial.peer; });
}

bool TcpMesh::may_reach(const asio::ip::address& address) const {
  return security_ || options_.insecure || is_loopback(address);
}

void TcpMesh::start_dial(Dial& dial) {
  dial.busy = true;
  ++dial.attempts;
  std::error_code not_numeric;
  const asio::ip::address address = asio::ip::make_address(dial.address.host, not_numeric);
  if (not_numeric) {
    look_up(dial.serial);
  } else {
    connect(dial, {Endpoint(address, dial.address.port)});
  }
}

void TcpMesh::look_up(std::uint64_t serial) {
  const Dial* dial = find_dial(serial);
  resolver_.async_resolve(dial->address.host, std::to_string(dial->address.port),
                          [this, serial](const std::error_code& error,
                                         const asio::ip::tcp::resolver::results_type& results) {
                            Dial* found = find_dial(serial);
                            if (found == nullptr) return;
                            if (error)
                              return dial_failed(serial,
                                                 "cannot look up the host: " + error.message());
                            std::vector<Endpoint> endpoints;
                            for (const auto& result : results) {
                              if (may_reach(result.endpoint().address()))
                                endpoints.push_back(result.endpoint());
                            }
                            if (endpoints.empty())
                              return dial_failed(serial,
                                                 "host is not this machine, and there is neither "
                                                 "session_key nor insecure");
                            connect(*found, endpoints);
                          });
}

void TcpMesh::connect(Dial& dial, const std::vector<Endpoint>& endpoints) {
  const auto link = new_link();
  link->dial = dial.serial;
  link->deadline = Clock::now() + options_.handshake_timeout;
  links_.emplace(link->serial(), link);
  asio::async_connect(link->socket(), endpoints,
                      [this, link](const std::error_code& error, const Endpoint&) {
                        if (link->phase == TcpLink::Phase::Closed) return;
                        if (error) return link->close("cannot connect: " + error.message());
                        if (is_joined_to_itself(link->socket())) {
                          return link->close("cannot connect: nobody listens");
                        }
                        link->phase = security_ ? TcpLink::Phase::Keying : TcpLink::Phase::Greeting;
                        link->deadline = Clock::now() + options_.handshake_timeout;
                        link->start(options_.socket_buffer_bytes);
                        if (link->phase == TcpLink::Phase::Closed) return;
                        if (security_) return ask_for_keys(*link);
                        greet(*link);
                      });
}

/// A dial has ended without a peer, or its link is gone.
void TcpMesh::dial_failed(std::uint64_t serial, const std::string& reason) {
  Dial* dial = find_dial(serial);
  if (dial == nullptr) return;
  dial->busy = false;
  dial->reason = reason;
  dial->due = Clock::now() + backoff(dial->attempts);
  publish_dials();
}

/// Its connection has ended: back-off starts over if that had lasted for a while.
void TcpMesh::redial_peer(PeerId peer, bool lasted) {
  for (Dial& dial : dials_) {
    if (dial.peer != peer) continue;
    if (lasted) dial.attempts = 0;
    dial.due = Clock::now() + backoff(dial.attempts);
  }
}

/// What a peer says of itself: it listens on that port of the host that it came from.
void TcpMesh::learn_address(const TcpLink& link) {
  const PeerId peer = link.hello.peer;
  if (Dial* dial = find_dial(link.dial)) {
    dial->peer = peer;
    dial->lasting = true;
    dial->reason.clear();
  }
  const std::uint16_t port = link.hello.listen_port;
  if (port == 0) return;
  std::erase_if(dials_, [&](const Dial& dial) {  // where it was before a restart
    const bool given = std::ranges::find(options_.connect, dial.address) != options_.connect.end();
    return dial.peer == peer && !dial.busy && !given && dial.address.port != port;
  });
  const HostPort address{plain(link.remote).to_string(), port};
  bool known = false;
  for (Dial& dial : dials_) {
    if (dial.peer == 0 && dial.address == address) dial.peer = peer;
    if (dial.peer != peer || dial.address.port != port) continue;
    dial.lasting = true;
    known = true;
  }
  if (!known) add_dial(address, peer, true, Clock::now());
}

/// What a peer says of others. Hearsay adds addresses and replaces none.
void TcpMesh::on_addresses(const TcpLink& link, const std::vector<PeerAddress>& addresses) {
  for (const PeerAddress& entry : addresses) {
    if (entry.peer == 0 || entry.peer == options_.self || entry.port == 0) continue;
    asio::ip::address ip = from_bytes(entry.ip);
    // On the teller's own host, which is this one only if the teller is here as well.
    if (ip.is_loopback()) ip = plain(link.remote);
    if (ip.is_unspecified() || ip.is_multicast() || !may_reach(ip)) continue;
    // One of the two dials at once, the other one only if that does not work out.
    const bool first = options_.self > entry.peer;
    const auto wait = first ? SteadyTime::duration(0) : 2 * options_.backoff_min;
    add_dial({ip.to_string(), entry.port}, entry.peer, false, Clock::now() + wait);
  }
  publish_dials();
}

/// Tells a newcomer of the others, and the others of it.
void TcpMesh::introduce(TcpLink& newcomer) {
  const auto send = [](TcpLink& link, std::span<const PeerAddress> addresses) {
    link.send(FrameType::Addresses, [&](pbd::ByteWriter& writer) { encode(writer, addresses); });
  };
  const PeerAddress own = peer_address_of(newcomer);
  std::vector<PeerAddress> others;
  for (const auto& link : snapshot()) {
    if (link.get() == &newcomer || link->phase != TcpLink::Phase::Attached) continue;
    if (link->hello.listen_port != 0) others.push_back(peer_address_of(*link));
    if (own.port != 0) send(*link, std::span(&own, 1));
  }
  for (std::size_t at = 0; at < others.size(); at += kMaxAddresses) {
    send(newcomer, std::span(others).subspan(at, std::min(kMaxAddresses, others.size() - at)));
  }
}

/// Doubles from backoff_min to backoff_max; jitter takes off up to half, so that peers which lost
/// each other at one moment do not meet in lockstep.
SteadyTime::duration TcpMesh::backoff(std::uint64_t attempts) {
  SteadyTime::duration wait = options_.backoff_min;
  for (std::uint64_t i = 1; i < attempts && wait < options_.backoff_max; ++i) wait *= 2;
  wait = std::min<SteadyTime::duration>(wait, options_.backoff_max);
  return wait - wait * static_cast<std::int64_t>(jitter_.next() >> 54) / 2048;
}

TcpMesh::Dial* TcpMesh::find_dial(std::uint64_t serial) {
  const auto at = std::ranges::find(dials_, serial, &Dial::serial);
  return at != dials_.end() ? &*at : nullptr;
}

void TcpMesh::publish_dials() {
  std::vector<DialStatus> out;
  out.reserve(dials_.size());
  for (const Dial& dial : dials_) {
    out.push_back({.address = dial.address,
                   .peer = dial.peer,
                   .connected = false,  // the table knows
                   .attempts = dial.attempts,
                   .reason = dial.reason});
  }
  table_.set_dials(std::move(out));
}

}  // namespace tandem::net
