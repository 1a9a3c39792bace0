// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "page_server/request.h"

#include <algorithm>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <cstdint>
#include <utility>

#include "page_server/access.h"

namespace tandem::page_server {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kPatience{10};
constexpr std::chrono::seconds kDelivery{60};  // half a megabyte to a slow phone
constexpr std::uint32_t kHeaderBytes = 8192;

constexpr std::string_view kSocket = "socket";

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

Request::Request(PageServer& server, boost::asio::ip::tcp::socket&& socket, Place place,
                 const boost::asio::ip::address& from, std::uint64_t number)
    : server_(server),
      stream_(std::move(socket)),
      place_(std::move(place)),
      buffer_(2 * kHeaderBytes),
      from_(from),
      number_(number) {}

Request::~Request() { server_.requests_.erase(number_); }

void Request::close() {
  Error ignored;
  stream_.socket().close(ignored);
  closed_ = true;
  place_.reset();
}

void Request::read() {
  parser_.emplace();
  parser_->header_limit(kHeaderBytes);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](Error error, std::size_t) {
                     if (self->closed_) return;
                     if (!error) return self->answer();
                     const Error ended = http::make_error_code(http::error::end_of_stream);
                     const bool malformed = error.category() == ended.category() && error != ended;
                     if (malformed) self->refuse(Status::bad_request);
                   });
}

void Request::answer() {
  UpgradeRequest request = parser_->release();
  const Options& options = server_.options_;
  const std::string_view host = view_of(request[http::field::host]);
  keep_alive_ = request.keep_alive();
  // Keeps out pages of other sites and other names of this machine.
  if (!server_.is_own_name(host) || request.count(http::field::host) != 1) {
    return refuse(Status::not_found);
  }
  if (request.count(http::field::origin) != 0) {
    const std::string_view origin = view_of(request[http::field::origin]);
    const std::string here(host);
    const bool own =
        origin == "http://" + here || (options.may_have_tls && origin == "https://" + here);
    if (!own) return refuse(Status::not_found);
  }
  if (request.method() != http::verb::get) return refuse(Status::not_found);
  const std::string_view target = view_of(request.target());
  const std::optional<std::string_view> path = below(options.token, target);
  if (!path && lacks_slash(options.token, target)) return send_on(target);
  if (!path) return refuse(Status::not_found, true);
  worth_ = Worth::Asks;
  if (path->substr(0, kSocket.size()) == kSocket) {
    const std::string_view rest = path->substr(kSocket.size());
    if (!beast::websocket::is_upgrade(request)) return refuse(Status::not_found);
    if (!server_.site_.has_room(rest)) return refuse(Status::service_unavailable);
    const std::string kept(rest);
    return server_.site_.upgrade(kept, std::move(request), std::move(stream_), std::move(place_));
  }
  const std::optional<File> file = server_.site_.file(*path);
  if (!file) return refuse(Status::not_found, true);
  send(*file, host);
}

void Request::send(const File& file, std::string_view host) {
  const Options& options = server_.options_;
  const std::string here(host);
  const std::string sockets = "ws://" + here + (options.may_have_tls ? " wss://" + here : "");
  file_.emplace();
  file_->result(Status::ok);
  file_->set(http::field::content_type, beast::string_view(file.mime.data(), file.mime.size()));
  if (file.gzip) file_->set(http::field::content_encoding, "gzip");
  // The page sends the token nowhere and loads nothing foreign.
  file_->set("Content-Security-Policy",
             "default-src 'none'; script-src " + options.scripts + "; style-src 'self'; img-src " +
                 options.images + "; connect-src 'self' " + sockets +
                 "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  file_->set("Cross-Origin-Resource-Policy", "same-origin");
  file_->set("Cross-Origin-Opener-Policy", "same-origin");
  file_->set("X-Content-Type-Options", "nosniff");
  file_->body() = {file.bytes.data(), file.bytes.size()};
  write();
}

void Request::refuse(Status status, bool help) {
  ++server_.refused_;
  keep_alive_ = false;
  file_.emplace();
  file_->result(status);
  if (help) {
    file_->set(http::field::content_type, "text/html; charset=utf-8");
    file_->set("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
    file_->body() = {server_.options_.help.data(), server_.options_.help.size()};
  }
  write();
}

void Request::send_on(std::string_view target) {
  const std::size_t query = std::min(target.find('?'), target.size());
  file_.emplace();
  file_->result(Status::permanent_redirect);
  file_->set(http::field::location,
             std::string(target.substr(0, query)) + '/' + std::string(target.substr(query)));
  write();
}

void Request::write() {
  file_->set("Referrer-Policy", "no-referrer");
  file_->set(http::field::cache_control, "no-store");
  file_->keep_alive(keep_alive_);
  file_->prepare_payload();
  stream_.expires_after(kDelivery);
  http::async_write(stream_, *file_, [self = shared_from_this()](Error error, std::size_t) {
    if (error || self->closed_) return;
    if (self->worth_ == Worth::Asks) self->worth_ = Worth::Waits;
    if (self->keep_alive_ && !self->server_.stopping_) return self->read();
    Error ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace tandem::page_server
