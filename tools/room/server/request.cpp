// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "server/request.h"

#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <utility>

#include "view/access.h"

namespace tandem::room {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using Error = boost::system::error_code;

constexpr std::chrono::seconds kPatience{10};
constexpr std::uint32_t kHeaderBytes = 8192;
constexpr std::string_view kSocket = "socket/";

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

Request::Request(RequestHost& host, boost::asio::ip::tcp::socket&& socket,
                 const boost::asio::ip::address& from)
    : host_(host), from_(from), stream_(std::move(socket)) {}

Request::~Request() { host_.ended(*this, from_); }

void Request::start() {
  host_.opened(*this, from_);
  read();
}

void Request::close() {
  Error ignored;
  stream_.socket().close(ignored);
}

void Request::read() {
  parser_.emplace();
  parser_->header_limit(kHeaderBytes);
  parser_->body_limit(0);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](Error error, std::size_t) {
                     if (!error) return self->answer();
                     const Error ended = http::make_error_code(http::error::end_of_stream);
                     const bool malformed = error.category() == ended.category() && error != ended;
                     if (malformed) self->refuse(http::status::bad_request);
                   });
}

void Request::answer() {
  http::request<http::empty_body> request = parser_->release();
  const std::string_view host = view_of(request[http::field::host]);
  keep_alive_ = request.keep_alive();
  const bool browser = request.count(http::field::origin) != 0;
  const std::string_view origin = view_of(request[http::field::origin]);
  // Neither another site's page nor another name of this machine gets in. Behind a proxy, by TLS.
  const std::string here(host);
  const bool own = request.count(http::field::host) == 1 && host_.is_own_name(host) &&
                   (!browser || origin == "http://" + here || origin == "https://" + here);
  if (!own || request.method() != http::verb::get) return refuse(http::status::not_found);
  const auto path = demos::view::below(host_.token(), view_of(request.target()));
  if (!path) return refuse(http::status::not_found);
  if (path->substr(0, kSocket.size()) == kSocket) {
    if (!beast::websocket::is_upgrade(request)) return refuse(http::status::not_found);
    std::string room(path->substr(kSocket.size()));
    if (!host_.may_join(room)) return refuse(http::status::service_unavailable);
    return host_.upgrade(std::move(room), std::move(request), std::move(stream_), from_);
  }
  const PageFile* const file = host_.file(*path);
  if (file == nullptr) return refuse(http::status::not_found);
  serve(*file, host);
}

void Request::serve(const PageFile& file, std::string_view host) {
  const std::string here(host);
  file_.emplace();
  file_->result(http::status::ok);
  file_->set(http::field::content_type, beast::string_view(file.mime.data(), file.mime.size()));
  file_->set(http::field::content_encoding, "gzip");
  file_->set(http::field::cache_control, "no-store");
  // Neither the token nor anything else leaves the page, and nothing foreign enters it.
  file_->set(
      "Content-Security-Policy",
      "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' "
      "data:; connect-src 'self' ws://" +
          here + " wss://" + here +
          "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  file_->set("Cross-Origin-Resource-Policy", "same-origin");
  file_->set("Cross-Origin-Opener-Policy", "same-origin");
  file_->set("Referrer-Policy", "no-referrer");
  file_->set("X-Content-Type-Options", "nosniff");
  file_->body() = {file.bytes.data(), file.bytes.size()};
  write(*file_);
}

void Request::refuse(http::status status) {
  host_.refused();
  nothing_.emplace();
  nothing_->result(status);
  nothing_->set(http::field::cache_control, "no-store");
  write(*nothing_);
}

template <class Response>
void Request::write(Response& response) {
  response.version(11);
  response.keep_alive(keep_alive_);
  response.prepare_payload();
  http::async_write(stream_, response, [self = shared_from_this()](Error error, std::size_t) {
    if (error) return;
    if (self->keep_alive_) return self->read();
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  });
}

}  // namespace tandem::room
