// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tandem/pbd/validate.h"
#include "view/access.h"
#include "view/frame_encoder.h"
#include "view/page_request.h"
#include "view/page_socket.h"

namespace tandem::demos::view {

namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSameAgain{500};  // between two frames in which nothing moves
constexpr std::chrono::milliseconds kAcceptAgain{100};

std::string host_of(const asio::ip::address& address, std::uint16_t port) {
  const std::string text = address.to_string();
  return (address.is_v6() ? '[' + text + ']' : text) + ':' + std::to_string(port);
}

}  // namespace

/// Everything below runs on the server's thread unless it says otherwise.
class Server::Impl final : public PageHost, public RequestHost {
 public:
  Impl(const ServerOptions& options, Layout layout, std::span<const Asset> assets)
      : options_(options),
        layout_(std::move(layout)),
        assets_(assets),
        encoder_(layout_),
        token_(random_token()),
        acceptor_(io_),
        again_(io_) {
    Error error;
    const asio::ip::address address = asio::ip::make_address(options.address, error);
    if (error) {
      pbd::detail::refuse("view address", "numeric", options.address);
    }
    const Tcp::endpoint endpoint(address, options.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw std::runtime_error("view: cannot listen on " + host_of(address, options.port) + ": " +
                               error.message());
    }
    address_ = address;
    port_ = acceptor_.local_endpoint().port();
    accept();
    thread_ = std::thread([this] { io_.run(); });
    pthread_getcpuclockid(thread_.native_handle(), &cpu_clock_);
  }

  ~Impl() override {
    asio::post(io_, [this] { stop(); });
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // From any thread.

  std::uint16_t port() const { return port_; }
  const std::string& token() const override { return token_; }
  std::string url() const {
    const bool any = address_.is_unspecified();
    const asio::ip::address shown = any ? (address_.is_v6() ? asio::ip::make_address("::1")
                                                            : asio::ip::make_address("127.0.0.1"))
                                        : address_;
    return "http://" + host_of(shown, port_) + '/' + token_ + '/';
  }
  void set_hello(std::string text) {
    asio::post(io_, [this, text = std::move(text)]() mutable { take_hello(std::move(text)); });
  }
  void tell(std::string text) {
    asio::post(io_, [this, text = std::move(text)] { tell_all(text); });
  }
  void tell(PageId page, std::string text) {
    asio::post(io_, [this, page, text = std::move(text)] { tell_one(page, text); });
  }
  void show(Frame& frame) {
    bool waiting = false;
    {
      const std::lock_guard lock(mutex_);
      std::swap(pending_, frame);
      waiting = std::exchange(has_pending_, true);
    }
    if (!waiting) asio::post(io_, [this] { take_frame(); });
  }
  void take(std::vector<PageEvent>& events) {
    const std::lock_guard lock(mutex_);
    events.insert(events.end(), events_.begin(), events_.end());
    events_.clear();
  }
  bool wants_overlays() const { return wants_overlays_; }
  std::size_t pages() const { return page_count_; }
  Counters counters() const {
    timespec cpu{};
    clock_gettime(cpu_clock_, &cpu);
    const std::lock_guard lock(mutex_);
    Counters result = counters_;
    result.cpu_s = static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec);
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

  bool is_named(std::string_view host) const override { return is_name_of(host, address_, port_); }
  const Asset* asset_of(std::string_view path) const override;
  bool is_full() const override { return pages_.size() >= options_.max_pages; }
  bool ends() const override { return stopping_; }
  void refused() override {
    const std::lock_guard lock(mutex_);
    ++counters_.refused;
  }
  void open(boost::beast::tcp_stream&& stream, PageSocket::Request request) override;
  void ended(PageRequest* request) override { requests_.erase(request); }

  void stop();
  void accept();
  void take_hello(std::string text);
  void tell_all(const std::string& text);
  void tell_one(PageId page, const std::string& text);
  void take_frame();
  void note_pages();
  void hand_on(PageId page, std::variant<Command, Left> what) {
    const std::lock_guard lock(mutex_);
    events_.push_back({page, std::move(what)});
  }

  ServerOptions options_;
  Layout layout_;
  std::span<const Asset> assets_;
  FrameEncoder encoder_;
  std::string token_;
  std::map<PageRequest*, std::weak_ptr<PageRequest>> requests_;
  asio::io_context io_{1};  // after what connections use when they end
  Tcp::acceptor acceptor_;
  asio::steady_timer again_;
  asio::ip::address address_;
  std::uint16_t port_ = 0;
  std::string hello_;
  bool stopping_ = false;
  Clock::time_point last_taken_;
  PageId next_page_ = 1;
  std::map<PageId, std::shared_ptr<PageSocket>> pages_;
  Frame current_;

  mutable std::mutex mutex_;
  Frame pending_;             // under mutex_
  bool has_pending_ = false;  // likewise
  std::vector<PageEvent> events_;
  Counters counters_;
  std::atomic<bool> wants_overlays_ = false;
  std::atomic<std::size_t> page_count_ = 0;
  std::thread thread_;
  clockid_t cpu_clock_{};  ///< of thread_
};

void Server::Impl::stop() {
  stopping_ = true;
  Error ignored;
  acceptor_.close(ignored);
  again_.cancel();
  for (const auto& [id, page] : std::map(pages_)) page->say_goodbye();
  for (const auto& [request, alive] : requests_) {
    if (const std::shared_ptr<PageRequest> one = alive.lock()) one->close();
  }
}

void Server::Impl::accept() {
  acceptor_.async_accept([this](Error error, Tcp::socket socket) {
    if (stopping_ || error == asio::error::operation_aborted) return;
    if (error) {
      // Out of descriptors, as a rule: not again at once.
      again_.expires_after(kAcceptAgain);
      return again_.async_wait([this](Error) {
        if (!stopping_) accept();
      });
    }
    if (requests_.size() + pages_.size() < options_.max_connections) {
      Error ignored;
      socket.set_option(Tcp::no_delay(true), ignored);
      const auto request = std::make_shared<PageRequest>(*this, std::move(socket));
      requests_[request.get()] = request;
      request->start();
    } else {
      refused();
    }
    accept();
  });
}

void Server::Impl::open(boost::beast::tcp_stream&& stream, PageSocket::Request request) {
  const PageId id = next_page_++;
  auto page = std::make_shared<PageSocket>(*this, id, layout_, std::move(stream));
  pages_[id] = page;
  note_pages();
  page->start(std::move(request));
}

void Server::Impl::take_hello(std::string text) {
  hello_ = std::move(text);
  for (const auto& [id, page] : pages_) page->greet();
}

void Server::Impl::tell_all(const std::string& text) {
  const auto shared = std::make_shared<const std::string>(text);
  // Of a copy: who has too many words waiting is closed, and no page any more.
  for (const auto& [id, page] : std::map(pages_)) page->say(shared);
}

void Server::Impl::tell_one(PageId page, const std::string& text) {
  const auto found = pages_.find(page);
  if (found == pages_.end()) return;
  const std::shared_ptr<PageSocket> alive = found->second;
  alive->say(std::make_shared<const std::string>(text));
}

void Server::Impl::take_frame() {
  {
    const std::lock_guard lock(mutex_);
    std::swap(current_, pending_);
    has_pending_ = false;
  }
  // Nobody looks; who comes sees the next one whole.
  if (pages_.empty()) return;
  const Clock::time_point now = Clock::now();
  if (!encoder_.take(current_, now - last_taken_ >= kSameAgain)) return;
  last_taken_ = now;
  {
    const std::lock_guard lock(mutex_);
    ++counters_.frames;
  }
  for (const auto& [id, page] : pages_) page->show();
}

void Server::Impl::note_pages() {
  bool wanted = false;
  for (const auto& [id, page] : pages_) wanted = wanted || page->wants_overlays();
  wants_overlays_ = wanted;
  page_count_ = pages_.size();
  if (pages_.empty()) encoder_.forget();
}

const Asset* Server::Impl::asset_of(std::string_view path) const {
  const auto found = std::find_if(assets_.begin(), assets_.end(),
                                  [path](const Asset& asset) { return asset.path == path; });
  return found == assets_.end() ? nullptr : &*found;
}

Server::Server(const ServerOptions& options, Layout layout, std::span<const Asset> assets)
    : impl_(std::make_unique<Impl>(options, std::move(layout), assets)) {}
Server::~Server() = default;
std::uint16_t Server::port() const { return impl_->port(); }
const std::string& Server::token() const { return impl_->token(); }
std::string Server::url() const { return impl_->url(); }
void Server::set_hello(std::string text) { impl_->set_hello(std::move(text)); }
void Server::tell(std::string text) { impl_->tell(std::move(text)); }
void Server::tell(PageId page, std::string text) { impl_->tell(page, std::move(text)); }
void Server::show(Frame& frame) { impl_->show(frame); }
void Server::take(std::vector<PageEvent>& events) { impl_->take(events); }
bool Server::wants_overlays() const { return impl_->wants_overlays(); }
std::size_t Server::pages() const { return impl_->pages(); }
Server::Counters Server::counters() const { return impl_->counters(); }

}  // namespace tandem::demos::view
