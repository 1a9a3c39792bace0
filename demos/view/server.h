// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "view/assets.h"
#include "view/protocol.h"

namespace tandem::demos::view {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< numeric
  std::uint16_t port = 0;             ///< 0 takes a free one
  std::size_t max_pages = 16;         ///< with a socket open
  std::size_t max_connections = 64;   ///< of any kind
};

/// A page is gone: its grabs end.
struct Left {};
struct PageEvent {
  PageId page = 0;
  std::variant<Command, Left> what;
};

/// Serves the page and its sockets on its own thread. Hands on valid commands of pages.
/// @par Thread safety  Safe: all methods from any thread.
class Server {
 public:
  /// @param assets  must outlive it
  /// @throws std::invalid_argument if the address is not numeric, std::runtime_error if it
  ///   cannot listen there
  Server(const ServerOptions& options, Layout layout, std::span<const Asset> assets);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// 32 unguessable hex digits.
  const std::string& token() const;
  std::string url() const;

  /// The first message to each new page. Pages wait until it is set.
  void set_hello(std::string text);
  /// To all pages.
  void tell(std::string text);
  /// To one page, if it is still connected.
  void tell(PageId page, std::string text);
  /// Shows a frame, unless a newer one replaces it before sending. `frame` is exchanged for an
  /// unused one.
  /// @pre as many panes and poses as the layout has
  void show(Frame& frame);
  /// Appends the pages' commands since the last call.
  void take(std::vector<PageEvent>& events);

  /// True if any page draws overlays.
  bool wants_overlays() const;
  std::size_t pages() const;

  struct Counters {
    std::uint64_t frames = 0;   ///< taken by the encoder
    std::uint64_t sent = 0;     ///< to pages, summed
    std::uint64_t keys = 0;     ///< of these, key frames
    std::uint64_t missed = 0;   ///< not sent, since a page was still busy
    std::uint64_t bytes = 0;    ///< of frames, without headers
    std::uint64_t refused = 0;  ///< refused connections and requests
    double cpu_s = 0.0;         ///< of its thread
  };
  Counters counters() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::demos::view
