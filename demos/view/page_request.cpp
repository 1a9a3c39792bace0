// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/page_request.h"

#include <algorithm>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <cstdint>
#include <utility>

#include "view/access.h"

namespace tandem::demos::view {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kPatience{10};
constexpr std::uint32_t kHeaderBytes = 8192;

/// For people who have lost part of the address. It says the same wherever they are.
constexpr std::string_view kHelp =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><title>Tandem: not this address</title>"
    "<h1>There is nothing at this address</h1>"
    "<p>A Tandem program is running here, but its page has a secret in its address, which is drawn "
    "anew at each start.</p>"
    "<p>Open the whole address that the program printed after <code>view:</code>, with the 32 "
    "letters and digits and the slash at its end.</p></html>";

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

PageRequest::PageRequest(RequestHost& host, boost::asio::ip::tcp::socket&& socket)
    : host_(host), stream_(std::move(socket)), buffer_(2 * kHeaderBytes) {}

PageRequest::~PageRequest() { host_.ended(this); }

void PageRequest::close() {
  Error ignored;
  stream_.socket().close(ignored);
}

void PageRequest::read() {
  parser_.emplace();
  parser_->header_limit(kHeaderBytes);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](Error error, std::size_t) {
                     if (!error) return self->answer();
                     const Error ended = http::make_error_code(http::error::end_of_stream);
                     const bool malformed = error.category() == ended.category() && error != ended;
                     if (malformed) self->refuse(Status::bad_request);
                   });
}

void PageRequest::answer() {
  PageSocket::Request request = parser_->release();
  const std::string_view host = view_of(request[http::field::host]);
  const std::string_view origin = view_of(request[http::field::origin]);
  keep_alive_ = request.keep_alive();
  if (!host_.is_named(host) || request.count(http::field::host) != 1) {
    return refuse(Status::not_found);
  }
  if (request.count(http::field::origin) != 0 && origin != "http://" + std::string(host)) {
    return refuse(Status::not_found);
  }
  if (request.method() != http::verb::get) return refuse(Status::not_found);
  const std::string_view target = view_of(request.target());
  const std::optional<std::string_view> path = below(host_.token(), target);
  if (!path && lacks_slash(host_.token(), target)) return send_on(target);
  if (!path) return refuse(Status::not_found, kHelp);
  if (*path == "socket") {
    if (!beast::websocket::is_upgrade(request)) return refuse(Status::not_found);
    if (host_.is_full()) return refuse(Status::service_unavailable);
    return host_.open(std::move(stream_), std::move(request));
  }
  const Asset* const asset = host_.asset_of(*path);
  if (asset == nullptr) return refuse(Status::not_found, kHelp);
  send(*asset, host);
}

void PageRequest::send(const Asset& asset, std::string_view host) {
  file_.emplace();
  file_->result(Status::ok);
  file_->set(http::field::content_type, beast::string_view(asset.mime.data(), asset.mime.size()));
  // Neither the token nor anything else leaves the page, and nothing foreign enters it.
  file_->set(http::field::cache_control, "no-store");
  file_->set("Content-Security-Policy",
             "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: "
             "blob:; connect-src 'self' ws://" +
                 std::string(host) +
                 "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  file_->set("Cross-Origin-Resource-Policy", "same-origin");
  file_->set("Cross-Origin-Opener-Policy", "same-origin");
  file_->set("Referrer-Policy", "no-referrer");
  file_->set("X-Content-Type-Options", "nosniff");
  file_->keep_alive(keep_alive_);
  file_->body() = {asset.bytes.data(), asset.bytes.size()};
  write();
}

void PageRequest::refuse(Status status, std::string_view why) {
  host_.refused();
  keep_alive_ = false;
  file_.emplace();
  file_->result(status);
  if (!why.empty()) {
    file_->set(http::field::content_type, "text/html; charset=utf-8");
    file_->set("Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'");
  }
  file_->keep_alive(false);
  file_->body() = {why.data(), why.size()};
  write();
}

void PageRequest::send_on(std::string_view target) {
  const std::size_t query = std::min(target.find('?'), target.size());
  file_.emplace();
  file_->result(Status::permanent_redirect);
  file_->set(http::field::location,
             std::string(target.substr(0, query)) + '/' + std::string(target.substr(query)));
  file_->set("Referrer-Policy", "no-referrer");
  file_->set(http::field::cache_control, "no-store");
  file_->keep_alive(keep_alive_);
  write();
}

void PageRequest::write() {
  file_->prepare_payload();
  stream_.expires_after(kPatience);
  http::async_write(stream_, *file_, [self = shared_from_this()](Error error, std::size_t) {
    if (error) return;
    if (self->keep_alive_ && !self->host_.ends()) return self->read();
    Error ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace tandem::demos::view
