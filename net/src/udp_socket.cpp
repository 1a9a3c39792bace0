// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_socket.h"

#include <algorithm>
#include <asio/post.hpp>
#include <chrono>
#include <exception>
#include <utility>

namespace tandem::net {

namespace {

constexpr int kReads = 4;  // batches before other work gets its turn
constexpr std::chrono::milliseconds kFloodPause{2};
constexpr std::int64_t kGoodbyeTime = 100'000'000;   // ns, for the last packets
constexpr std::int64_t kLongestSleep = 100'000'000;  // ns
constexpr std::size_t kPathWaiting = 1024;           // datagrams

/// System clock minus steady clock.
std::int64_t system_correction(std::int64_t steady) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
             .count() -
         steady;
}

Address address_of(const asio::ip::udp::endpoint& endpoint) {
  Address out;
  const auto ip = endpoint.address();
  out.ip = ip.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, ip.to_v4()).to_bytes()
                      : ip.to_v6().to_bytes();
  out.port = endpoint.port();
  return out;
}

}  // namespace

UdpSocket::UdpSocket(const UdpOptions& options, const UdpNodeOptions& node)
    : options_(options),
      socket_(context_, options_),
      node_(
          started(node), crypto::system_random(),
          [this](std::span<const std::byte> datagram, const Address& to) { send(datagram, to); }) {
  lookups_.reserve(options_.connect.size());
  for (const HostPort& address : options_.connect) {
    lookups_.push_back({{.address = address}, asio::steady_timer(context_)});
  }
  if (options_.kernel_filter) {
    (void)attach_filter(socket_.socket().native_handle(), node_.receiver_prefix());
  }
  receive();
  thread_ = std::thread([this] { run(); });
}

UdpSocket::~UdpSocket() {
  {
    const std::scoped_lock lock(mutex_);
    const auto patience =
        std::chrono::duration_cast<std::chrono::nanoseconds>(options_.flush_timeout).count();
    flush_until_ = now() + patience;
    wake();
  }
  thread_.join();
  // Before the objects that they call are destroyed.
  for (const auto& path : paths_) {
    if (path) path->receive({});
  }
}

void UdpSocket::connect(std::shared_ptr<DatagramPath> path) {
  DatagramPath& added = *path;
  std::uint64_t number = 0;
  {
    const std::scoped_lock lock(mutex_);
    number = paths_.size();
    paths_.push_back(std::move(path));
  }
  added.receive([this, number](std::span<const std::byte> datagram) {
    if (path_waiting_ >= kPathWaiting) return;  // lost, as datagrams are
    ++path_waiting_;
    asio::post(context_, [this, number, bytes = std::vector(datagram.begin(), datagram.end())] {
      --path_waiting_;
      {
        const std::scoped_lock lock(mutex_);
        if (paths_[number]) (void)node_.on_path(bytes, number, now());
      }
      step();
    });
  });
  with(true, [number](UdpNode& node, std::int64_t time) { node.dial(path_address(number), time); });
}

void UdpSocket::disconnect(const DatagramPath& path) {
  std::shared_ptr<DatagramPath> old;
  {
    const std::scoped_lock lock(mutex_);
    const auto at = std::ranges::find(paths_, &path, &std::shared_ptr<DatagramPath>::get);
    if (at == paths_.end()) return;
    const std::int64_t time = now();
    node_.hang_up(static_cast<std::uint64_t>(at - paths_.begin()), "its path was taken away", time);
    node_.poll(time);  // tells the other end
    old = std::exchange(*at, nullptr);
  }
  old->receive({});
}

std::int64_t UdpSocket::now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

UdpNodeOptions UdpSocket::started(UdpNodeOptions node) const {
  if (!socket_.forbids_fragments()) {
    node.connection.max_datagram = std::min(node.connection.max_datagram, MtuSearch::kBase);
  }
  node.path_limit = [this](std::uint64_t path) { return paths_[path]->max_datagram(); };
  node.start = now();
  node.correction = system_correction(node.start);
  return node;
}

void UdpSocket::follow_system_clock(std::int64_t time) {
  if (options_.clock == Clock::System) node_.set_correction(system_correction(time), time);
}

void UdpSocket::run() {
  try {
    for (Lookup& lookup : lookups_) look_up(lookup);
  } catch (const std::exception&) {
    // Out of memory: peers that are not dialled may still dial us.
  }
  for (;;) {
    try {
      step();
      context_.run();
      return;
    } catch (const std::exception&) {
      // Out of memory at worst: the work in progress is lost like a packet.
      receive();
    }
  }
}

void UdpSocket::look_up(Lookup& lookup) {
  const auto& [host, port] = lookup.status.address;
  std::error_code no_number;
  const auto address = asio::ip::make_address(host, no_number);
  if (!no_number) {
    const Endpoint endpoint(address, port);
    return dial(lookup, {&endpoint, 1});
  }
  resolver_.async_resolve(host, std::to_string(port),
                          [this, &lookup](const std::error_code& error,
                                          const asio::ip::udp::resolver::results_type& results) {
                            if (error == asio::error::operation_aborted) return;
                            if (error) {
                              return look_up_again(lookup,
                                                   "cannot look up the host: " + error.message());
                            }
                            std::vector<Endpoint> found;
                            for (const auto& result : results) found.push_back(result.endpoint());
                            dial(lookup, found);
                          });
}

void UdpSocket::dial(Lookup& lookup, std::span<const Endpoint> found) {
  const auto usable = std::find_if(found.begin(), found.end(), [this](const Endpoint& endpoint) {
    return socket_.reaches(endpoint.address());
  });
  if (usable == found.end()) return look_up_again(lookup, "host has no IPv4 address");
  const std::scoped_lock lock(mutex_);
  ++lookup.status.attempts;
  lookup.status.found = true;
  lookup.status.reason.clear();
  node_.dial(address_of(*usable), now());
  wake();
}

void UdpSocket::look_up_again(Lookup& lookup, const std::string& reason) {
  {
    const std::scoped_lock lock(mutex_);
    ++lookup.status.attempts;
    lookup.status.reason = reason;
  }
  lookup.again.expires_after(options_.backoff_max);
  lookup.again.async_wait([this, &lookup](const std::error_code& error) {
    if (!error) look_up(lookup);
  });
}

std::vector<UdpLookup> UdpSocket::lookups() {
  const std::scoped_lock lock(mutex_);
  std::vector<UdpLookup> out;
  for (const Lookup& lookup : lookups_) out.push_back(lookup.status);
  return out;
}

void UdpSocket::wake() {
  if (wake_posted_) return;
  wake_posted_ = true;
  asio::post(context_, [this] { step(); });
}

void UdpSocket::receive() {
  if (waiting_) return;
  waiting_ = true;
  socket_.socket().async_wait(asio::ip::udp::socket::wait_read,
                              [this](const std::error_code& error) {
                                waiting_ = false;
                                if (!error) on_readable();
                              });
}

void UdpSocket::on_readable() {
  std::int64_t time = now();
  for (int i = 0; i < kReads; ++i) {
    const auto read = batch_.read(socket_.socket().native_handle());
    if (read == DatagramBatch::Read::Nothing) break;
    if (read == DatagramBatch::Read::Error) continue;  // an ICMP error of an earlier send
    const std::scoped_lock lock(mutex_);
    time = now();
    for (std::size_t k = 0; k < batch_.size(); ++k) {
      if (!node_.on_datagram(batch_.bytes(k), batch_.from(k), time)) flood_.count_useless();
    }
    if (batch_.size() < DatagramBatch::kCount) break;
  }
  step();
  // A timer would not help: each datagram would wake the reactor.
  if (flood_.is_flooded(time)) std::this_thread::sleep_for(kFloodPause);
  receive();
}

void UdpSocket::step() {
  const std::scoped_lock lock(mutex_);
  wake_posted_ = false;
  const std::int64_t time = now();
  if (flush_until_ != INT64_MAX) {
    if (!left_ && (time >= flush_until_ || !node_.table().busy())) {
      left_ = true;
      flush_until_ = time + kGoodbyeTime;
      node_.leave("has left", time);
    }
    if (left_ && (node_.connections() == 0 || time >= flush_until_)) {
      std::error_code ignored;
      socket_.socket().close(ignored);
      context_.stop();
      return;
    }
  }
  follow_system_clock(time);
  node_.poll(time);
  const bool ending = flush_until_ != INT64_MAX;
  const std::int64_t sleep = std::clamp<std::int64_t>(node_.next_due(time) - time, 200'000,
                                                      ending ? 5'000'000 : kLongestSleep);
  timer_.expires_after(std::chrono::nanoseconds(sleep));
  timer_.async_wait([this](const std::error_code& error) {
    if (!error) step();
  });
}

void UdpSocket::send(std::span<const std::byte> datagram, const Address& to) {
  if (is_path(to)) {
    if (const auto& path = paths_[path_number(to)]) path->send(datagram);
    return;
  }
  socket_.send(datagram, to);
}

}  // namespace tandem::net
