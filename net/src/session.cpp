// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/session.h"

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <system_error>
#include <thread>

#include "console_close.h"
#include "tandem/pbd/parse_number.h"
#include "tandem/pbd/validate.h"
#include "timer_resolution.h"

namespace tandem::net {

HostPort parse_host_port(std::string_view text) {
  const auto fail = [&](const char* rule) -> HostPort {
    pbd::detail::refuse("address", rule, '"' + std::string(text) + '"');
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return fail("HOST:PORT");
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return fail("[HOST]:PORT where HOST is an IPv6 address");
  }
  if (host.empty()) return fail("HOST:PORT with a host");
  std::uint16_t port = 0;
  if (!pbd::detail::parse_number(digits, port) || port == 0) {
    return fail("HOST:PORT with a port from 1 to 65535");
  }
  return {std::string(host), port};
}

std::string to_string(const HostPort& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? '[' + address.host + ']' : address.host) + ':' + std::to_string(address.port);
}

class __attribute__((visibility("hidden"))) StopSignal::Impl {
 public:
  Impl() : signals_(context_, SIGINT, SIGTERM) {
#ifdef SIGBREAK  // Ctrl+Break on Windows
    signals_.add(SIGBREAK);
#endif
    listen_to_console_close();
    signals_.async_wait([this](const std::error_code& error, int) {
      if (error) return;
      std::error_code ignored;
      signals_.clear(ignored);  // a second signal ends the process
      request();
    });
    thread_ = std::thread([this] { context_.run(); });
  }

  ~Impl() {
    asio::post(context_, [this] {
      std::error_code ignored;
      signals_.cancel(ignored);
    });
    thread_.join();
  }

  bool requested() const {
    const std::lock_guard lock(mutex_);
    return requested_;
  }

  void request() {
    {
      const std::lock_guard lock(mutex_);
      requested_ = true;
    }
    changed_.notify_all();
  }

  bool wait(std::chrono::nanoseconds duration) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, duration, [this] { return requested_; });
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  bool requested_ = false;
  [[maybe_unused]] TimerResolution timer_resolution_;
  asio::io_context context_{1};
  asio::signal_set signals_;
  std::thread thread_;
};

StopSignal::StopSignal() : impl_(std::make_unique<Impl>()) {}
StopSignal::~StopSignal() = default;
bool StopSignal::requested() const { return impl_->requested(); }
void StopSignal::request() { impl_->request(); }
bool StopSignal::wait(std::chrono::nanoseconds duration) const { return impl_->wait(duration); }

}  // namespace tandem::net
