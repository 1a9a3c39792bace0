// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "page_server/page_server.h"

#include <chrono>
#include <stdexcept>

#include "page_server/access.h"
#include "page_server/own_port.h"
#include "page_server/request.h"
#include "tandem/pbd/cpu_timer.h"
#include "tandem/pbd/validate.h"

namespace tandem::page_server {

namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;

constexpr std::chrono::milliseconds kAcceptAgain{100};

bool is_token(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string host_of(const asio::ip::address& address, std::uint16_t port) {
  const std::string text = address.to_string();
  return (address.is_v6() ? '[' + text + ']' : text) + ':' + std::to_string(port);
}

std::string page_of(const std::string& help) {
  return "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width\"><title>Tandem: not this address</title>"
         "<h1>There is nothing at this address</h1>" +
         help + "</html>";
}

}  // namespace

PageServer::PageServer(Options options, Site& site) : options_(std::move(options)), site_(site) {
  if (options_.token.empty()) options_.token = random_token();
  if (!is_token(options_.token)) pbd::detail::refuse("token", "32 hex digits", options_.token);
  options_.help = page_of(options_.help);
  Error error;
  address_ = asio::ip::make_address(options_.address, error);
  if (error) pbd::detail::refuse("address", "numeric", options_.address);
  const Tcp::endpoint endpoint(address_, options_.port);
  acceptor_.open(endpoint.protocol(), error);
  if (!error) acceptor_.set_option(OwnPort(true), error);
  if (!error) acceptor_.bind(endpoint, error);
  if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    throw std::runtime_error("cannot listen on " + host_of(address_, options_.port) + ": " +
                             error.message());
  }
  port_ = acceptor_.local_endpoint().port();
}

void PageServer::start() {
  accept();
  thread_ = std::thread([this] {
    while (io_.run_one() > 0) cpu_s_.store(pbd::thread_cpu_seconds(), std::memory_order_relaxed);
  });
}

void PageServer::stop() {
  post([this] {
    stopping_ = true;
    Error ignored;
    acceptor_.close(ignored);
    again_.cancel();
    site_.end();
    for (const auto& [request, weak] : std::map(requests_)) {
      if (const auto alive = weak.lock()) alive->close();
    }
  });
  thread_.join();
}

std::string PageServer::url() const {
  const bool any = address_.is_unspecified();
  const asio::ip::address shown =
      any ? asio::ip::make_address(address_.is_v6() ? "::1" : "127.0.0.1") : address_;
  return "http://" + (options_.name.empty() ? host_of(shown, port_) : options_.name) + '/' +
         options_.token + '/';
}

double PageServer::cpu_s() const { return cpu_s_.load(std::memory_order_relaxed); }

bool PageServer::is_own_name(std::string_view host) const {
  return (!options_.name.empty() && host == options_.name) || is_name_of(host, address_, port_);
}

void PageServer::accept() {
  acceptor_.async_accept([this](Error error, Tcp::socket socket) {
    if (stopping_ || error == asio::error::operation_aborted) return;
    if (error) {
      // Usually out of file descriptors: retry later.
      again_.expires_after(kAcceptAgain);
      return again_.async_wait([this](Error) {
        if (!stopping_) accept();
      });
    }
    Error unknown;
    const asio::ip::address from = socket.remote_endpoint(unknown).address();
    if (Place place = unknown ? nullptr : place_of(from)) {
      Error ignored;
      socket.set_option(Tcp::no_delay(true), ignored);
      const auto request =
          std::make_shared<Request>(*this, std::move(socket), std::move(place), from, ++came_);
      requests_[came_] = request;
      request->start();
    } else {
      ++refused_;
    }
    accept();
  });
}

Place PageServer::place_of(const asio::ip::address& from) {
  const auto at = taken_.find(from);
  const bool many = at != taken_.end() && at->second >= options_.max_per_address;
  if (many && !from.is_loopback() && !make_room(&from)) return nullptr;
  if (all_taken_ >= options_.max_connections && !make_room(nullptr)) return nullptr;
  std::size_t& taken = taken_[from];
  ++all_taken_;
  ++taken;
  return Place(&taken, [this, from](void*) {
    --all_taken_;
    if (--taken_[from] == 0) taken_.erase(from);
  });
}

bool PageServer::make_room(const asio::ip::address* from) {
  std::shared_ptr<Request> least;
  for (const auto& [number, weak] : requests_) {
    const auto request = weak.lock();
    if (!request || request->is_closed() || (from != nullptr && request->from() != *from)) continue;
    if (least == nullptr || request->worth() < least->worth()) least = request;
  }
  // Connections with a request in progress are kept.
  if (least == nullptr || least->worth() == Request::Worth::Asks) return false;
  least->close();
  ++refused_;
  return true;
}

}  // namespace tandem::page_server
