// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string_view>

#include "page_server/page_server.h"

namespace tandem::page_server {

/// One connection that asks for files, until it asks for a socket.
/// @par Thread safety  One object: the thread of its socket.
class Request : public std::enable_shared_from_this<Request> {
 public:
  /// The server must outlive it.
  Request(PageServer& server, boost::asio::ip::tcp::socket&& socket, Place place);
  ~Request();
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  void start() { read(); }
  void close();

 private:
  using Status = boost::beast::http::status;

  void read();
  void answer();
  void send(const File& file, std::string_view host);
  /// @param help  whether it is said how to get in
  void refuse(Status status, bool help = false);
  /// Who knows the token and has left out the slash is sent to the page, query and all.
  void send_on(std::string_view target);
  void write();

  PageServer& server_;
  boost::beast::tcp_stream stream_;
  Place place_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::span_body<const char>>> file_;
  bool keep_alive_ = false;
};

}  // namespace tandem::page_server
