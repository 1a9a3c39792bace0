// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/metrics_server.h"

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

namespace tandem::demos {

class MetricsServer::Impl {
 public:
  Impl(const std::string& address, std::uint16_t port) {
    // Two, so that one client that says nothing does not keep out the other.
    server_.new_task_queue = [] { return new httplib::ThreadPool(2); };
    server_.set_keep_alive_max_count(1);
    server_.set_read_timeout(2);
    server_.set_payload_max_length(1024);
    server_.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      response.set_content(text_, "text/plain; version=0.0.4");
    });
    int bound = port;
    if (port == 0) {
      bound = server_.bind_to_any_port(address);
    } else if (!server_.bind_to_port(address, port)) {
      bound = -1;
    }
    if (bound <= 0) {
      throw std::runtime_error("metrics.port = " + std::to_string(port) + ": cannot listen on " +
                               address);
    }
    port_ = static_cast<std::uint16_t>(bound);
    thread_ = std::thread([this] {
      server_.listen_after_bind();
      ended_ = true;
    });
    // A server that does not run yet cannot be stopped.
    while (!server_.is_running() && !ended_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  ~Impl() {
    server_.stop();
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::uint16_t port() const { return port_; }
  void publish(std::string text) {
    const std::lock_guard lock(mutex_);
    text_ = std::move(text);
  }

 private:
  httplib::Server server_;
  std::mutex mutex_;
  std::string text_;
  std::uint16_t port_ = 0;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

bool has_metrics_server() { return true; }

MetricsServer::MetricsServer(const std::string& address, std::uint16_t port)
    : impl_(std::make_unique<Impl>(address, port)) {}
MetricsServer::~MetricsServer() = default;
std::uint16_t MetricsServer::port() const { return impl_->port(); }
void MetricsServer::publish(std::string text) { impl_->publish(std::move(text)); }

}  // namespace tandem::demos
