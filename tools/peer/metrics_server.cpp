// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/metrics_server.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <list>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "page_server/own_port.h"

namespace tandem::demos {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kPatience{2};  // for a request and its answer
constexpr std::size_t kMaxClients = 16;       // at a time; a new one replaces the oldest
constexpr std::uint32_t kHeaderBytes = 8192;

}  // namespace

/// One thread for all clients, none of which blocks another.
class MetricsServer::Impl {
 public:
  Impl(const std::string& address, std::uint16_t port) : acceptor_(io_) {
    Error error;
    const Tcp::endpoint endpoint(asio::ip::make_address(address, error), port);
    if (!error) acceptor_.open(endpoint.protocol(), error);
    // Reuses the port of a server that has just ended, not of a running one.
    if (!error) acceptor_.set_option(page_server::OwnPort(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw std::runtime_error("metrics.port = " + std::to_string(port) + ": cannot listen on " +
                               address + ": " + error.message());
    }
    port_ = acceptor_.local_endpoint().port();
    accept();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Impl() {
    asio::post(io_, [this] {
      Error ignored;
      acceptor_.close(ignored);
      for (Client& client : clients_) client.stream.close();
    });
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
  struct Client {
    explicit Client(Tcp::socket socket) : stream(std::move(socket)) {
      request.header_limit(kHeaderBytes);
    }
    beast::tcp_stream stream;
    beast::flat_buffer buffer;
    http::request_parser<http::empty_body> request;
    http::response<http::string_body> response;
  };
  using Place = std::list<Client>::iterator;

  void accept() {
    acceptor_.async_accept([this](const Error& error, Tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (!error) {
        // Its handler removes it from the list.
        if (clients_.size() >= kMaxClients) clients_.front().stream.close();
        serve(clients_.emplace(clients_.end(), std::move(socket)));
      }
      accept();
    });
  }

  void serve(Place client) {
    client->stream.expires_after(kPatience);
    http::async_read_header(client->stream, client->buffer, client->request,
                            [this, client](const Error& error, std::size_t) {
                              if (error) return end(client);
                              answer(client);
                            });
  }

  void answer(Place client) {
    const auto& request = client->request.get();
    auto& response = client->response;
    response.version(request.version());
    response.keep_alive(false);
    if (request.target() != "/metrics") {
      response.result(http::status::not_found);
    } else if (request.method() != http::verb::get) {
      response.result(http::status::method_not_allowed);
    } else {
      response.set(http::field::content_type, "text/plain; version=0.0.4");
      const std::lock_guard lock(mutex_);
      response.body() = text_;
    }
    response.prepare_payload();
    http::async_write(client->stream, response, [this, client](const Error&, std::size_t) {
      Error ignored;
      client->stream.socket().shutdown(Tcp::socket::shutdown_send, ignored);
      end(client);
    });
  }

  void end(Place client) { clients_.erase(client); }

  asio::io_context io_;
  Tcp::acceptor acceptor_;
  std::list<Client> clients_;  ///< oldest first
  std::mutex mutex_;
  std::string text_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

bool has_metrics_server() { return true; }

MetricsServer::MetricsServer(const std::string& address, std::uint16_t port)
    : impl_(std::make_unique<Impl>(address, port)) {}
MetricsServer::~MetricsServer() = default;
std::uint16_t MetricsServer::port() const { return impl_->port(); }
void MetricsServer::publish(std::string text) { impl_->publish(std::move(text)); }

}  // namespace tandem::demos
