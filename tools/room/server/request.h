// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/member_socket.h"
#include "server/page_files.h"

namespace tandem::room {

class Request;

/// What a connection asks; on the thread that it runs on.
class RequestHost {
 public:
  virtual ~RequestHost() = default;
  virtual const std::string& token() const = 0;
  /// Whether a request's Host names this server.
  virtual bool is_own_name(std::string_view host) const = 0;
  virtual const PageFile* file(std::string_view path) const = 0;
  virtual bool may_join(std::string_view room) const = 0;
  virtual void upgrade(std::string room, MemberSocket::Request request,
                       boost::beast::tcp_stream&& stream, const boost::asio::ip::address& from) = 0;
  virtual void refused() = 0;
  virtual void opened(Request& request, const boost::asio::ip::address& from) = 0;
  virtual void ended(Request& request, const boost::asio::ip::address& from) = 0;
};

/// One connection that asks for files, until it asks for a room's socket.
class Request : public std::enable_shared_from_this<Request> {
 public:
  Request(RequestHost& host, boost::asio::ip::tcp::socket&& socket,
          const boost::asio::ip::address& from);
  ~Request();
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  void start();
  void close();

 private:
  void read();
  void answer();
  void serve(const PageFile& file, std::string_view host);
  void refuse(boost::beast::http::status status);
  template <class Response>
  void write(Response& response);

  RequestHost& host_;
  boost::asio::ip::address from_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_{16384};
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::span_body<const char>>> file_;
  std::optional<boost::beast::http::response<boost::beast::http::empty_body>> nothing_;
  bool keep_alive_ = false;
};

}  // namespace tandem::room
