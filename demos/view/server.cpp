// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <ctime>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "view/access.h"
#include "view/frame_encoder.h"

namespace tandem::demos::view {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{10};  // with a request, and with a page that is gone
constexpr std::chrono::seconds kHandshake{3};  // at the beginning and at the end of a socket
constexpr std::chrono::milliseconds kSameAgain{500};  // between two frames in which nothing moves
constexpr std::chrono::milliseconds kAcceptAgain{100};
constexpr std::chrono::milliseconds kBeat{250};
constexpr std::uint32_t kHeaderBytes = 8192;
constexpr std::size_t kMostWords = 256;  // waiting for one page
constexpr int kSocketBytes = 64 * 1024;  // what waits in the system is old when it is seen

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

std::string host_of(const asio::ip::address& address, std::uint16_t port) {
  const std::string text = address.to_string();
  return (address.is_v6() ? '[' + text + ']' : text) + ':' + std::to_string(port);
}

}  // namespace

/// Everything below runs on the server's thread unless it says otherwise.
class Server::Impl {
 public:
  Impl(const ServerOptions& options, Layout layout, std::span<const Asset> assets)
      : options_(options),
        layout_(std::move(layout)),
        assets_(assets),
        encoder_(layout_),
        token_(random_token()),
        acceptor_(io_),
        again_(io_),
        beat_(io_) {
    Error error;
    const asio::ip::address address = asio::ip::make_address(options.address, error);
    if (error) {
      throw std::invalid_argument("view address = " + options.address + " breaks: numeric");
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
    beat();
    thread_ = std::thread([this] { run(); });
  }

  ~Impl() {
    asio::post(io_, [this] { stop(); });
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // From any thread.

  std::uint16_t port() const { return port_; }
  const std::string& token() const { return token_; }
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
    const std::lock_guard lock(mutex_);
    return counters_;
  }

 private:
  class Page;
  class Request;

  void run() {
    io_.run();
    const std::lock_guard lock(mutex_);
    note_cpu();
  }

  void stop();
  void accept();
  void beat();
  void take_hello(std::string text);
  void tell_all(const std::string& text);
  void tell_one(PageId page, const std::string& text);
  void take_frame();
  void send_to_all();
  void note_pages();
  /// @pre mutex_ is held
  void note_cpu() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    counters_.cpu_s = static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  void hand_on(PageId page, std::variant<Command, Left> what) {
    const std::lock_guard lock(mutex_);
    events_.push_back({page, std::move(what)});
  }
  void count_refused() {
    const std::lock_guard lock(mutex_);
    ++counters_.refused;
  }

  /// Whether a request may have been meant for us: neither another site's page nor another name of
  /// this machine gets in.
  bool is_ours(std::string_view host) const;
  const Asset* asset_of(std::string_view path) const;

  ServerOptions options_;
  Layout layout_;
  std::span<const Asset> assets_;
  FrameEncoder encoder_;
  std::string token_;
  std::size_t connections_ = 0;
  std::map<Request*, std::weak_ptr<Request>> requests_;
  asio::io_context io_{1};  // after what connections use when they end
  Tcp::acceptor acceptor_;
  asio::steady_timer again_;
  asio::steady_timer beat_;
  asio::ip::address address_;
  std::uint16_t port_ = 0;
  std::string hello_;
  bool stopping_ = false;
  Clock::time_point last_taken_;
  PageId next_page_ = 1;
  std::map<PageId, std::shared_ptr<Page>> pages_;
  Frame current_;

  mutable std::mutex mutex_;
  Frame pending_;             // under mutex_
  bool has_pending_ = false;  // likewise
  std::vector<PageEvent> events_;
  Counters counters_;
  std::atomic<bool> wants_overlays_ = false;
  std::atomic<std::size_t> page_count_ = 0;
  std::thread thread_;
};

/// One page's socket.
class Server::Impl::Page : public std::enable_shared_from_this<Page> {
 public:
  Page(Impl& server, PageId id, beast::tcp_stream&& stream)
      : server_(server), id_(id), socket_(std::move(stream)), commands_(server.layout_) {}
  ~Page() { --server_.connections_; }

  void start(http::request<http::empty_body> request) {
    request_ = std::move(request);
    beast::get_lowest_layer(socket_).expires_never();
    websocket::stream_base::timeout timeout{};
    timeout.handshake_timeout = kHandshake;
    timeout.idle_timeout = kPatience;
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(kMostBytes);
    socket_.auto_fragment(false);
    // What a slow page has not read yet is to wait here, where the newest wins.
    Error ignored;
    beast::get_lowest_layer(socket_).socket().set_option(
        asio::socket_base::send_buffer_size(kSocketBytes), ignored);
    socket_.async_accept(request_, [self = shared_from_this()](Error error) {
      if (error) return self->close();
      self->open_ = true;
      self->greet();
      self->read();
    });
  }
  /// The words that come before all others; nothing is said before them.
  void greet() {
    if (!open_ || greeted_ || server_.hello_.empty()) return;
    greeted_ = true;
    words_.push_front(std::make_shared<const std::string>(server_.hello_));
    write();
  }
  void say(std::shared_ptr<const std::string> text) {
    if (!greeted_ || closed_) return;
    if (words_.size() >= kMostWords) return close();
    words_.push_back(std::move(text));
    write();
  }
  /// There is a new frame.
  void show() {
    if (!greeted_ || closed_) return;
    if (writing_ || !words_.empty()) {
      const std::lock_guard lock(server_.mutex_);
      ++server_.counters_.missed;
    }
    write();
  }
  void close() {
    if (std::exchange(closed_, true)) return;
    Error ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    if (greeted_ || open_) server_.hand_on(id_, Left{});
    server_.pages_.erase(id_);
    server_.note_pages();
  }
  bool wants_overlays() const { return overlays_; }

 private:
  void read() {
    socket_.async_read(incoming_, [self = shared_from_this()](Error error, std::size_t) {
      if (error || !self->socket_.got_text()) return self->close();
      self->hear();
      if (!self->closed_) self->read();
    });
  }
  void hear() {
    const beast::flat_buffer::const_buffers_type data = incoming_.data();
    const std::string_view text(static_cast<const char*>(data.data()), data.size());
    const bool in_time = allowance_.take(Clock::now());
    auto said = in_time ? commands_.read(text) : Refused{"too many commands"};
    incoming_.consume(incoming_.size());
    if (!in_time) return close();
    if (const Refused* const refused = std::get_if<Refused>(&said)) {
      return say(std::make_shared<const std::string>(refused_text(refused->text)));
    }
    Command& command = std::get<Command>(said);
    if (const Ping* const ping = std::get_if<Ping>(&command)) {
      return say(std::make_shared<const std::string>(pong_text(ping->time)));
    }
    if (const Want* const want = std::get_if<Want>(&command)) {
      overlays_ = want->overlays;
      return server_.note_pages();
    }
    server_.hand_on(id_, std::move(command));
  }
  /// Words first; else the newest frame, where the page has not got it.
  void write() {
    if (writing_ || closed_) return;
    if (!words_.empty()) {
      text_ = std::move(words_.front());
      words_.pop_front();
      socket_.text(true);
      return send(asio::buffer(*text_));
    }
    const std::uint32_t number = server_.encoder_.number();
    if (number == 0 || number == sent_) return;
    const bool key = sent_ == 0 || sent_ + 1 != number;
    sent_ = number;
    frame_ = server_.encoder_.bytes(key, overlays_);
    {
      const std::lock_guard lock(server_.mutex_);
      ++server_.counters_.sent;
      server_.counters_.keys += key ? 1 : 0;
      server_.counters_.bytes += frame_->size();
    }
    socket_.binary(true);
    send(asio::buffer(*frame_));
  }
  void send(asio::const_buffer bytes) {
    writing_ = true;
    socket_.async_write(bytes, [self = shared_from_this()](Error error, std::size_t) {
      self->writing_ = false;
      if (error) return self->close();
      self->write();
    });
  }

  Impl& server_;
  PageId id_;
  websocket::stream<beast::tcp_stream> socket_;
  http::request<http::empty_body> request_;
  CommandReader commands_;
  Allowance allowance_;
  beast::flat_buffer incoming_{kMostBytes};
  std::deque<std::shared_ptr<const std::string>> words_;
  std::shared_ptr<const std::string> text_;  ///< being written
  FrameEncoder::Bytes frame_;                ///< likewise
  std::uint32_t sent_ = 0;                   ///< number of the last frame
  bool open_ = false;
  bool greeted_ = false;
  bool writing_ = false;
  bool closed_ = false;
  bool overlays_ = false;
};

/// One connection that asks for files, until it asks for the socket.
class Server::Impl::Request : public std::enable_shared_from_this<Request> {
 public:
  Request(Impl& server, Tcp::socket&& socket) : server_(server), stream_(std::move(socket)) {
    ++server_.connections_;
  }
  ~Request() {
    server_.requests_.erase(this);
    if (!handed_on_) --server_.connections_;
  }

  void start() {
    server_.requests_[this] = weak_from_this();
    read();
  }
  void close() {
    Error ignored;
    stream_.socket().close(ignored);
  }

 private:
  void read() {
    parser_.emplace();
    parser_->header_limit(kHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kPatience);
    http::async_read(
        stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
          if (!error) return self->answer();
          const Error ended = http::make_error_code(http::error::end_of_stream);
          const bool malformed = error.category() == ended.category() && error != ended;
          if (malformed) self->refuse(http::status::bad_request);
        });
  }

  void answer() {
    http::request<http::empty_body> request = parser_->release();
    const std::string_view host = view_of(request[http::field::host]);
    const std::string_view origin = view_of(request[http::field::origin]);
    keep_alive_ = request.keep_alive();
    if (!server_.is_ours(host) || request.count(http::field::host) != 1) {
      return refuse(http::status::not_found);
    }
    if (request.count(http::field::origin) != 0 && origin != "http://" + std::string(host)) {
      return refuse(http::status::not_found);
    }
    const std::optional<std::string_view> path = below(server_.token_, view_of(request.target()));
    if (!path) return refuse(http::status::not_found);
    if (request.method() != http::verb::get) return refuse(http::status::not_found);
    if (*path == "socket") {
      const bool full = server_.pages_.size() >= server_.options_.max_pages;
      if (!websocket::is_upgrade(request)) return refuse(http::status::not_found);
      if (full) return refuse(http::status::service_unavailable);
      return hand_on(std::move(request));
    }
    const Asset* const asset = server_.asset_of(*path);
    if (asset == nullptr) return refuse(http::status::not_found);
    file_.emplace();
    file_->result(http::status::ok);
    file_->set(http::field::content_type,
               beast::string_view(asset->mime.data(), asset->mime.size()));
    // Neither the token nor anything else leaves the page, and nothing foreign enters it.
    const std::string here(host);
    file_->set(http::field::cache_control, "no-store");
    file_->set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: "
               "blob:; connect-src 'self' ws://" +
                   here + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    file_->set("Cross-Origin-Resource-Policy", "same-origin");
    file_->set("Cross-Origin-Opener-Policy", "same-origin");
    file_->set("Referrer-Policy", "no-referrer");
    file_->set("X-Content-Type-Options", "nosniff");
    file_->keep_alive(keep_alive_);
    file_->body() = {asset->bytes.data(), asset->bytes.size()};
    file_->prepare_payload();
    write(*file_);
  }

  void refuse(http::status status) {
    server_.count_refused();
    keep_alive_ = false;
    nothing_.emplace();
    nothing_->result(status);
    nothing_->keep_alive(false);
    nothing_->prepare_payload();
    write(*nothing_);
  }

  template <class Response>
  void write(Response& response) {
    stream_.expires_after(kPatience);
    http::async_write(stream_, response, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return;
      if (self->keep_alive_ && !self->server_.stopping_) return self->read();
      Error ignored;
      self->stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    });
  }

  void hand_on(http::request<http::empty_body> request) {
    handed_on_ = true;
    const PageId id = server_.next_page_++;
    auto page = std::make_shared<Page>(server_, id, std::move(stream_));
    server_.pages_[id] = page;
    server_.note_pages();
    page->start(std::move(request));
  }

  Impl& server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{2 * kHeaderBytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<http::response<http::span_body<const char>>> file_;
  std::optional<http::response<http::empty_body>> nothing_;
  bool keep_alive_ = false;
  bool handed_on_ = false;
};

void Server::Impl::stop() {
  stopping_ = true;
  Error ignored;
  acceptor_.close(ignored);
  again_.cancel();
  beat_.cancel();
  while (!pages_.empty()) {
    const std::shared_ptr<Page> page = pages_.begin()->second;
    page->close();
  }
  for (const auto& [request, alive] : requests_) {
    if (const std::shared_ptr<Request> one = alive.lock()) one->close();
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
    if (connections_ < options_.max_connections) {
      Error ignored;
      socket.set_option(Tcp::no_delay(true), ignored);
      std::make_shared<Request>(*this, std::move(socket))->start();
    } else {
      count_refused();
    }
    accept();
  });
}

void Server::Impl::beat() {
  beat_.expires_after(kBeat);
  beat_.async_wait([this](Error) {
    if (stopping_) return;
    {
      const std::lock_guard lock(mutex_);
      note_cpu();
    }
    beat();
  });
}

void Server::Impl::take_hello(std::string text) {
  hello_ = std::move(text);
  for (const auto& [id, page] : std::map(pages_)) page->greet();
}

void Server::Impl::tell_all(const std::string& text) {
  const auto shared = std::make_shared<const std::string>(text);
  for (const auto& [id, page] : std::map(pages_)) page->say(shared);
}

void Server::Impl::tell_one(PageId page, const std::string& text) {
  const auto found = pages_.find(page);
  if (found == pages_.end()) return;
  const std::shared_ptr<Page> alive = found->second;
  alive->say(std::make_shared<const std::string>(text));
}

void Server::Impl::take_frame() {
  {
    const std::lock_guard lock(mutex_);
    std::swap(current_, pending_);
    has_pending_ = false;
  }
  if (pages_.empty()) {
    // Nobody looks; who comes sees the next one whole.
    return;
  }
  const Clock::time_point now = Clock::now();
  if (!encoder_.take(current_, now - last_taken_ >= kSameAgain)) return;
  last_taken_ = now;
  {
    const std::lock_guard lock(mutex_);
    ++counters_.frames;
  }
  for (const auto& [id, page] : std::map(pages_)) page->show();
}

void Server::Impl::note_pages() {
  bool wanted = false;
  for (const auto& [id, page] : pages_) wanted = wanted || page->wants_overlays();
  wants_overlays_ = wanted;
  page_count_ = pages_.size();
}

bool Server::Impl::is_ours(std::string_view host) const {
  if (host.empty()) return false;
  const std::size_t colon = host.rfind(':');
  const std::string port = std::to_string(port_);
  const bool bare = colon == std::string_view::npos || host.back() == ']';
  if (bare ? port != "80" : host.substr(colon + 1) != port) return false;
  std::string name(bare ? host : host.substr(0, colon));
  if (name == "localhost") return address_.is_loopback() || address_.is_unspecified();
  if (name.size() > 2 && name.front() == '[' && name.back() == ']') {
    name = name.substr(1, name.size() - 2);
  }
  // A name that somebody else made point here is none of ours.
  Error error;
  const asio::ip::address address = asio::ip::make_address(name, error);
  return !error && (address == address_ || address_.is_unspecified());
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
