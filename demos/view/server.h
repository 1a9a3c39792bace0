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

/// A page is gone: what it held is let go.
struct Left {};
struct PageEvent {
  PageId page = 0;
  std::variant<Command, Left> what;
};

/// Serves the page and talks to it, on a thread of its own. What a page asks is checked here; what
/// is left of it is handed on.
/// @par Thread safety  Safe: all methods from any thread.
class Server {
 public:
  /// @param assets  must outlive it
  /// @throws std::invalid_argument where the address is not numeric, std::runtime_error where it
  ///   cannot listen there
  Server(const ServerOptions& options, Layout layout, std::span<const Asset> assets);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// 32 hex digits that nobody guesses.
  const std::string& token() const;
  std::string url() const;

  /// What pages that come from now on are told first. Before it is set they wait.
  void set_hello(std::string text);
  /// To all pages.
  void tell(std::string text);
  /// To one page, where it is still there.
  void tell(PageId page, std::string text);
  /// Shows a frame, unless a newer one is there before it could be sent. The frame is exchanged for
  /// one that is no longer needed, whose memory serves again.
  /// @pre as many panes and poses as the layout has
  void show(Frame& frame);
  /// Appends what pages have asked for since the last call.
  void take(std::vector<PageEvent>& events);

  /// Whether any page draws overlays.
  bool wants_overlays() const;
  std::size_t pages() const;

  struct Counters {
    std::uint64_t frames = 0;   ///< taken by the encoder
    std::uint64_t sent = 0;     ///< to pages, summed
    std::uint64_t keys = 0;     ///< of these, key frames
    std::uint64_t missed = 0;   ///< not sent, since a page was not done with the last one
    std::uint64_t bytes = 0;    ///< of frames, without headers
    std::uint64_t refused = 0;  ///< connections and requests that were turned away
    double cpu_s = 0.0;         ///< of its thread
  };
  Counters counters() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::demos::view
