// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "view/assets.h"
#include "view/page_socket.h"

namespace tandem::demos::view {

class PageRequest;

/// What a request asks of its server, on the server's thread.
class RequestHost {
 public:
  virtual ~RequestHost() = default;
  /// What the target of each request begins with.
  virtual const std::string& token() const = 0;
  /// Whether that is the server's own address.
  virtual bool is_named(std::string_view host) const = 0;
  /// Null where there is no such file.
  virtual const Asset* asset_of(std::string_view path) const = 0;
  /// Whether it takes no more pages.
  virtual bool is_full() const = 0;
  /// Whether it answers no more than what has been asked.
  virtual bool ends() const = 0;
  virtual void refused() = 0;
  /// The connection becomes a page's socket.
  virtual void open(boost::beast::tcp_stream&& stream, PageSocket::Request request) = 0;
  virtual void ended(PageRequest* request) = 0;
};

/// One connection that asks for files, until it asks for the socket.
/// @par Thread safety  One object: the thread of its socket.
class PageRequest : public std::enable_shared_from_this<PageRequest> {
 public:
  /// The host must outlive it.
  PageRequest(RequestHost& host, boost::asio::ip::tcp::socket&& socket);
  ~PageRequest();
  PageRequest(const PageRequest&) = delete;
  PageRequest& operator=(const PageRequest&) = delete;

  void start() { read(); }
  void close();

 private:
  using Status = boost::beast::http::status;

  void read();
  void answer();
  void send(const Asset& asset, std::string_view host);
  void refuse(Status status, std::string_view why = {});
  /// Who knows the token and has left out the slash is sent to the page, query and all.
  void send_on(std::string_view target);
  void write();

  RequestHost& host_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::span_body<const char>>> file_;
  bool keep_alive_ = false;
};

}  // namespace tandem::demos::view
