// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/ip/address.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "page_server/page_server.h"

namespace tandem::page_server {

/// One connection that asks for files until it becomes a socket.
/// @par Thread safety  One object: the thread of its socket.
class Request : public std::enable_shared_from_this<Request> {
 public:
  /// The server must outlive it.
  /// @param number  unique within the server
  Request(PageServer& server, boost::asio::ip::tcp::socket&& socket, Place place,
          const boost::asio::ip::address& from, std::uint64_t number);
  ~Request();
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  void start() { read(); }
  /// Also frees its place.
  void close();
  bool is_closed() const { return closed_; }
  const boost::asio::ip::address& from() const { return from_; }
  enum class Worth : std::uint8_t {
    Unknown,  ///< has not shown the token
    Waits,    ///< has shown it, idle
    Asks,     ///< has shown it, being answered
  };
  Worth worth() const { return worth_; }

 private:
  using Status = boost::beast::http::status;

  void read();
  void answer();
  void send(const File& file, std::string_view host);
  /// @param help  add the help page
  void refuse(Status status, bool help = false);
  /// Redirects a visitor who left out the slash to the page, with the query.
  void send_on(std::string_view target);
  void write();

  PageServer& server_;
  boost::beast::tcp_stream stream_;
  Place place_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::span_body<const char>>> file_;
  boost::asio::ip::address from_;
  std::uint64_t number_;
  Worth worth_ = Worth::Unknown;
  bool keep_alive_ = false;
  bool closed_ = false;
};

}  // namespace tandem::page_server
