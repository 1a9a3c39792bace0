// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace tandem::page_server {

struct Options {
  std::string address = "127.0.0.1";  ///< numeric
  std::uint16_t port = 0;             ///< 0 takes a free one
  std::string token;                  ///< 32 hex digits; "" generates them
  /// Host and port of a proxy in front, perhaps with TLS, "play.example.org". "": none
  std::string name;
  bool may_have_tls = false;  ///< requests by https are own ones too
  /// All kinds. If all are taken, the oldest one without the token is closed, then an idle one;
  /// sockets stay.
  std::size_t max_connections = 64;
  std::size_t max_per_address = 64;     ///< the same for one remote address
  std::string scripts = "'self'";       ///< Content-Security-Policy: where scripts may come from
  std::string images = "'self' data:";  ///< Content-Security-Policy: where images may come from
  /// HTML for visitors with an incomplete address; the same for all.
  std::string help;
};

struct File {
  std::string_view mime;
  std::string_view bytes;  ///< outlive the server
  bool gzip = false;
};

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;
/// One connection's slot among those of the server; free once it is gone.
using Place = std::shared_ptr<void>;

/// The contents. Called on the server's thread.
class Site {
 public:
  virtual ~Site() = default;
  /// @param path  below the token; "" is the page
  virtual std::optional<File> file(std::string_view path) const = 0;
  /// True if a socket may open there. @param path  follows "socket" in the target
  virtual bool has_room(std::string_view path) const = 0;
  /// A connection becomes a socket. @pre has_room(path)
  virtual void upgrade(std::string_view path, UpgradeRequest request,
                       boost::beast::tcp_stream&& stream, Place place) = 0;
  /// The server ends: close all sockets.
  virtual void end() = 0;
};

class Request;

/// Serves a page below a token to requests that use the server's own name and come from no other
/// site's page; hands on connections that become sockets. Runs on its own thread.
/// @par Thread safety  Public methods: safe but for start() and stop(). Private ones: its thread.
class PageServer {
 public:
  /// Listens at once, but calls the site only after start().
  /// @param site  outlives stop()
  /// @throws std::invalid_argument naming field, value and rule; std::runtime_error if it cannot
  /// listen
  PageServer(Options options, Site& site);
  /// @pre stopped, if it was started
  ~PageServer() = default;
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  void start();
  void stop();
  /// Runs `work` on the server's thread.
  template <class Work>
  void post(Work&& work) {
    boost::asio::post(io_, std::forward<Work>(work));
  }

  std::uint16_t port() const { return port_; }
  const std::string& token() const { return options_.token; }
  std::string url() const;
  /// Requests and connections that were refused.
  std::uint64_t refused() const { return refused_; }
  /// Processor time of its thread, s. @pre started
  double cpu_s() const;

 private:
  friend class Request;

  bool is_own_name(std::string_view host) const;
  void accept();
  /// Null if all are taken.
  Place place_of(const boost::asio::ip::address& from);
  /// Closes the least valuable connection of an address, or of all.
  /// @return whether there was one
  bool make_room(const boost::asio::ip::address* from);

  Options options_;
  Site& site_;
  std::map<std::uint64_t, std::weak_ptr<Request>> requests_;  ///< in order of arrival
  std::uint64_t came_ = 0;
  std::map<boost::asio::ip::address, std::size_t> taken_;
  std::size_t all_taken_ = 0;
  boost::asio::io_context io_{1};  // before it: members that connections use when they end
  boost::asio::ip::tcp::acceptor acceptor_{io_};
  boost::asio::steady_timer again_{io_};
  boost::asio::ip::address address_;
  std::uint16_t port_ = 0;
  bool stopping_ = false;
  std::atomic<std::uint64_t> refused_ = 0;
  std::thread thread_;
  std::atomic<double> cpu_s_{0};  ///< of thread_
};

}  // namespace tandem::page_server
