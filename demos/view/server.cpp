// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/server.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "page_server/page_server.h"
#include "view/frame_encoder.h"
#include "view/page_socket.h"

namespace tandem::demos::view {

namespace {

using page_server::File;
using page_server::Place;
using page_server::UpgradeRequest;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSameAgain{500};  // between two frames without motion

/// For visitors with an incomplete address.
constexpr std::string_view kHelp =
    "<p>A Tandem program is running here, but its page has a secret in its address, which is drawn "
    "anew at each start.</p>"
    "<p>Open the whole address that the program printed after <code>view:</code>, with the 32 "
    "letters and digits and the slash at its end.</p>";

page_server::Options web_options(const ServerOptions& options) {
  page_server::Options web;
  web.address = options.address;
  web.port = options.port;
  web.max_connections = web.max_per_address = options.max_connections;
  web.images = "'self' data: blob:";
  web.help = kHelp;
  return web;
}

}  // namespace

/// Members run on the server's thread unless noted otherwise.
class Server::Impl final : public PageHost, public page_server::Site {
 public:
  Impl(const ServerOptions& options, Layout layout, std::span<const Asset> assets)
      : options_(options),
        layout_(std::move(layout)),
        assets_(assets),
        encoder_(layout_),
        web_(web_options(options), *this) {
    web_.start();
  }
  ~Impl() override { web_.stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // From any thread.

  const page_server::PageServer& web() const { return web_; }
  void set_hello(std::string text) {
    web_.post([this, text = std::move(text)]() mutable { take_hello(std::move(text)); });
  }
  void tell(std::string text) {
    web_.post([this, text = std::move(text)] { tell_all(text); });
  }
  void tell(PageId page, std::string text) {
    web_.post([this, page, text = std::move(text)] { tell_one(page, text); });
  }
  void show(Frame& frame) {
    bool waiting = false;
    {
      const std::lock_guard lock(mutex_);
      std::swap(pending_, frame);
      waiting = std::exchange(has_pending_, true);
    }
    if (!waiting) web_.post([this] { take_frame(); });
  }
  void take(std::vector<PageEvent>& events) {
    const std::lock_guard lock(mutex_);
    events.insert(events.end(), events_.begin(), events_.end());
    events_.clear();
  }
  bool wants_overlays() const { return wants_overlays_; }
  std::size_t pages() const { return page_count_; }
  Counters counters() const {
    const std::lock_guard lock(mutex_);
    Counters result = counters_;
    result.refused = web_.refused();
    result.cpu_s = web_.cpu_s();
    return result;
  }

 private:
  const std::string& hello() const override { return hello_; }
  FrameEncoder& encoder() override { return encoder_; }
  void heard(PageId page, Command command) override { hand_on(page, std::move(command)); }
  void wants_changed() override { note_pages(); }
  void sent(bool key, std::size_t bytes) override {
    const std::lock_guard lock(mutex_);
    ++counters_.sent;
    counters_.keys += key ? 1 : 0;
    counters_.bytes += bytes;
  }
  void missed() override {
    const std::lock_guard lock(mutex_);
    ++counters_.missed;
  }
  void gone(PageId page, bool opened) override {
    if (opened) hand_on(page, Left{});
    pages_.erase(page);
    note_pages();
  }

  // Site
  std::optional<File> file(std::string_view path) const override;
  bool has_room(std::string_view path) const override {
    return path.empty() && pages_.size() < options_.max_pages;
  }
  void upgrade(std::string_view path, UpgradeRequest request, boost::beast::tcp_stream&& stream,
               Place place) override;
  void end() override {
    for (const auto& [id, page] : std::map(pages_)) page.socket->say_goodbye();
  }

  void take_hello(std::string text);
  void tell_all(const std::string& text);
  void tell_one(PageId page, const std::string& text);
  void take_frame();
  void note_pages();
  void hand_on(PageId page, std::variant<Command, Left> what) {
    const std::lock_guard lock(mutex_);
    events_.push_back({page, std::move(what)});
  }

  struct Page {
    std::shared_ptr<PageSocket> socket;
    Place place;
  };

  ServerOptions options_;
  Layout layout_;
  std::span<const Asset> assets_;
  FrameEncoder encoder_;
  page_server::PageServer web_;
  std::string hello_;
  Clock::time_point last_taken_;
  PageId next_page_ = 1;
  std::map<PageId, Page> pages_;  // destroyed before the server, whose thread uses them
  Frame current_;

  mutable std::mutex mutex_;
  Frame pending_;             // under mutex_
  bool has_pending_ = false;  // under mutex_
  std::vector<PageEvent> events_;
  Counters counters_;
  std::atomic<bool> wants_overlays_ = false;
  std::atomic<std::size_t> page_count_ = 0;
};

void Server::Impl::upgrade(std::string_view /*path*/, UpgradeRequest request,
                           boost::beast::tcp_stream&& stream, Place place) {
  const PageId id = next_page_++;
  auto page = std::make_shared<PageSocket>(*this, id, layout_, std::move(stream));
  pages_[id] = {page, std::move(place)};
  note_pages();
  page->start(std::move(request));
}

void Server::Impl::take_hello(std::string text) {
  hello_ = std::move(text);
  for (const auto& [id, page] : pages_) page.socket->greet();
}

void Server::Impl::tell_all(const std::string& text) {
  const auto shared = std::make_shared<const std::string>(text);
  // Iterates over a copy: a page with too many queued messages is closed and removed.
  for (const auto& [id, page] : std::map(pages_)) page.socket->say(shared);
}

void Server::Impl::tell_one(PageId page, const std::string& text) {
  const auto found = pages_.find(page);
  if (found == pages_.end()) return;
  const std::shared_ptr<PageSocket> alive = found->second.socket;
  alive->say(std::make_shared<const std::string>(text));
}

void Server::Impl::take_frame() {
  {
    const std::lock_guard lock(mutex_);
    std::swap(current_, pending_);
    has_pending_ = false;
  }
  // Without pages: the next one to come gets a full frame.
  if (pages_.empty()) return;
  const Clock::time_point now = Clock::now();
  if (!encoder_.take(current_, now - last_taken_ >= kSameAgain)) return;
  last_taken_ = now;
  {
    const std::lock_guard lock(mutex_);
    ++counters_.frames;
  }
  for (const auto& [id, page] : pages_) page.socket->show();
}

void Server::Impl::note_pages() {
  bool wanted = false;
  for (const auto& [id, page] : pages_) wanted = wanted || page.socket->wants_overlays();
  wants_overlays_ = wanted;
  page_count_ = pages_.size();
  if (pages_.empty()) encoder_.forget();
}

std::optional<File> Server::Impl::file(std::string_view path) const {
  const auto found = std::find_if(assets_.begin(), assets_.end(),
                                  [path](const Asset& asset) { return asset.path == path; });
  if (found == assets_.end()) return std::nullopt;
  return File{found->mime, found->bytes};
}

Server::Server(const ServerOptions& options, Layout layout, std::span<const Asset> assets)
    : impl_(std::make_unique<Impl>(options, std::move(layout), assets)) {}
Server::~Server() = default;
std::uint16_t Server::port() const { return impl_->web().port(); }
const std::string& Server::token() const { return impl_->web().token(); }
std::string Server::url() const { return impl_->web().url(); }
void Server::set_hello(std::string text) { impl_->set_hello(std::move(text)); }
void Server::tell(std::string text) { impl_->tell(std::move(text)); }
void Server::tell(PageId page, std::string text) { impl_->tell(page, std::move(text)); }
void Server::show(Frame& frame) { impl_->show(frame); }
void Server::take(std::vector<PageEvent>& events) { impl_->take(events); }
bool Server::wants_overlays() const { return impl_->wants_overlays(); }
std::size_t Server::pages() const { return impl_->pages(); }
Server::Counters Server::counters() const { return impl_->counters(); }

}  // namespace tandem::demos::view
