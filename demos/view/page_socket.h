// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "page_server/access.h"
#include "page_server/page_server.h"
#include "view/frame_encoder.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// Callbacks of a page's socket, on the socket's thread.
class PageHost {
 public:
  virtual ~PageHost() = default;
  /// The first message to pages; "" = not known yet.
  virtual const std::string& hello() const = 0;
  virtual FrameEncoder& encoder() = 0;
  virtual void heard(PageId page, Command command) = 0;
  /// A page starts or stops drawing overlays.
  virtual void wants_changed() = 0;
  /// A frame is being sent to a page.
  virtual void sent(bool key, std::size_t bytes) = 0;
  /// A page skipped a frame: it was still busy with the last one.
  virtual void missed() = 0;
  /// @param opened  false: the socket never opened
  virtual void gone(PageId page, bool opened) = 0;
};

/// One page's socket: text messages first, then the newest frame that the page does not have.
/// @par Thread safety  One object: the thread of its socket.
class PageSocket : public std::enable_shared_from_this<PageSocket> {
 public:
  using Request = page_server::UpgradeRequest;

  /// Host and layout must outlive it.
  PageSocket(PageHost& host, PageId id, const Layout& layout, boost::beast::tcp_stream&& stream);

  /// @param request  for the upgrade
  void start(Request request);
  /// Sends the hello; nothing is sent before it.
  void greet();
  /// May close the socket.
  void say(std::shared_ptr<const std::string> text);
  /// Sends a new frame when possible.
  void show();
  void close();
  /// Closes the socket and tells the page not to reconnect.
  void say_goodbye();
  bool wants_overlays() const { return overlays_; }

 private:
  void read();
  void hear();
  void write();
  void send(boost::asio::const_buffer bytes);

  PageHost& host_;
  PageId id_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  Request request_;
  CommandReader commands_;
  page_server::Allowance allowance_{kCommandsPerSecond};
  boost::beast::flat_buffer incoming_{kMaxBytes};
  std::deque<std::shared_ptr<const std::string>> words_;
  std::shared_ptr<const std::string> text_;  ///< being written
  FrameEncoder::Bytes frame_;                ///< being written
  std::uint32_t sent_ = 0;                   ///< number of the last frame
  bool open_ = false;
  bool greeted_ = false;
  bool writing_ = false;
  bool closed_ = false;
  bool overlays_ = false;
};

}  // namespace tandem::demos::view
