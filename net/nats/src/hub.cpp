// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/hub.h"

#include <algorithm>
#include <array>
#include <asio/ip/address.hpp>
#include <stdexcept>
#include <system_error>

#include "direct_way.h"
#include "hub_impl.h"
#include "require.h"
#include "tandem/consensus/shared_id.h"

namespace tandem::nats {

namespace {

constexpr std::chrono::milliseconds kDriveEvery{5};
constexpr std::int64_t kConnectTimeout = 2000;  // ms
constexpr std::int64_t kPingEvery = 2000;       // ms: detects a server that has become silent
constexpr int kPingsOut = 2;

void check(natsStatus status, const char* what) {
  if (status == NATS_OK) return;
  throw std::runtime_error(std::string("NatsHub: cannot ") + what + ": " +
                           natsStatus_GetText(status));
}

std::vector<std::string> urls_of(const HubOptions& options) {
  std::vector<std::string> out;
  out.reserve(options.servers.size());
  for (const net::HostPort& server : options.servers) {
    out.push_back((options.tls ? "tls://" : "nats://") + net::to_string(server));
  }
  return out;
}

NatsOwned<natsOptions> library_options(const HubOptions& options,
                                       std::atomic<std::uint64_t>* slow) {
  natsOptions* made = nullptr;
  check(natsOptions_Create(&made), "begin");
  NatsOwned<natsOptions> out(made);
  const std::vector<std::string> urls = urls_of(options);
  std::vector<const char*> texts;
  texts.reserve(urls.size());
  for (const std::string& url : urls) texts.push_back(url.c_str());
  check(natsOptions_SetServers(made, texts.data(), static_cast<int>(texts.size())), "use a server");
  if (!options.user.empty()) {
    check(natsOptions_SetUserInfo(made, options.user.c_str(), options.password.c_str()),
          "use a name");
  }
  if (options.tls) check(natsOptions_SetSecure(made, true), "use TLS");
  check(natsOptions_SetTimeout(made, kConnectTimeout), "set a time");
  check(natsOptions_SetMaxReconnect(made, -1), "set a number");
  check(natsOptions_SetReconnectWait(made, options.reconnect_wait.count()), "set a time");
  check(natsOptions_SetReconnectJitter(made, options.reconnect_wait.count(),
                                       options.reconnect_wait.count()),
        "set a time");
  // Publishing without a server fails at once: a restarted server must not get messages meant for
  // its predecessor.
  check(natsOptions_SetReconnectBufSize(made, 1), "set a size");
  check(natsOptions_SetPingInterval(made, kPingEvery), "set a time");
  check(natsOptions_SetMaxPingsOut(made, kPingsOut), "set a number");
  // One thread delivers the messages of all subscriptions.
  check(natsOptions_UseGlobalMessageDelivery(made, true), "set the delivery");
  const auto on_error = [](natsConnection*, natsSubscription*, natsStatus error, void* counter) {
    if (error == NATS_SLOW_CONSUMER) ++*static_cast<std::atomic<std::uint64_t>*>(counter);
  };
  check(natsOptions_SetErrorHandler(made, on_error, slow), "set a handler");
  const auto on_connected = [](natsConnection*, void*) {};
  check(natsOptions_SetRetryOnFailedConnect(made, true, on_connected, nullptr), "set retries");
  return out;
}

}  // namespace

void HubOptions::validate() const {
  net::require(!servers.empty(), "HubOptions", "servers", std::string(), "at least one");
  for (const net::HostPort& server : servers) {
    net::require(!server.host.empty() && server.port != 0, "HubOptions", "servers",
                 net::to_string(server), "HOST:PORT");
  }
  net::require(!user.empty() || password.empty(), "HubOptions", "password", std::string("given"),
               "none without a user");
  net::require(
      reconnect_wait >= std::chrono::milliseconds(10) && reconnect_wait <= std::chrono::minutes(1),
      "HubOptions", "reconnect_wait", reconnect_wait.count(), "in [10 ms, 1 min]");
  if (direct) direct->validate();
}

void DirectOptions::validate() const {
  const auto is_numeric = [](const std::string& text) {
    std::error_code error;
    (void)asio::ip::make_address(text, error);
    return !error;
  };
  net::require(is_numeric(listen_address), "DirectOptions", "listen_address", listen_address,
               "a numeric address");
  net::require(reachable_at.size() <= net::DirectWay::kMaxOffered, "DirectOptions",
               "reachable_at.size()", reachable_at.size(), "at most 4");
  for (const net::HostPort& each : reachable_at) {
    net::require(is_numeric(each.host) && each.port != 0, "DirectOptions", "reachable_at",
                 net::to_string(each), "numeric addresses with ports");
  }
}

NatsHub::Impl::Impl(const HubOptions& options) : driven_by_thread_(options.driven) {
  options.validate();
  if (options.direct) direct_ = std::make_unique<DirectSocket>(*options.direct);
  const NatsOwned<natsOptions> own = library_options(options, &slow_);
  natsStatistics* counts = nullptr;
  check(natsStatistics_Create(&counts), "count");
  statistics_.reset(counts);
  natsConnection* made = nullptr;
  const natsStatus status = natsConnection_Connect(&made, own.get());
  connection_.reset(made);
  if (status != NATS_NOT_YET_CONNECTED) check(status, "connect");
  if (driven_by_thread_) thread_ = std::thread([this] { run(); });
}

NatsHub::Impl::~Impl() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
  if (thread_.joinable()) thread_.join();
  jobs_.stop();
  if (connection_ == nullptr) return;
  natsConnection_FlushTimeout(connection_.get(), 100);
  natsConnection_Close(connection_.get());
}

void NatsHub::Impl::publish(const std::string& subject, std::span<const std::byte> bytes) {
  // Messages kept by the client library for an absent server are outdated when it is back.
  if (!connected() || natsConnection_Publish(connection_.get(), subject.c_str(), bytes.data(),
                                             static_cast<int>(bytes.size())) != NATS_OK) {
    ++lost_;
  }
}

NatsOwned<natsSubscription> NatsHub::Impl::subscribe(const std::string& subject, Hear hear) {
  // Callbacks may run while the subscription is destroyed: their data is freed after the last one.
  auto kept = std::make_unique<Hear>(std::move(hear));
  const auto on_message = [](natsConnection*, natsSubscription*, natsMsg* message, void* closure) {
    const NatsOwned<natsMsg> owned(message);
    const auto* data = reinterpret_cast<const std::byte*>(natsMsg_GetData(message));
    (*static_cast<Hear*>(closure))(
        {data, static_cast<std::size_t>(natsMsg_GetDataLength(message))});
  };
  natsSubscription* made = nullptr;
  if (natsConnection_Subscribe(&made, connection_.get(), subject.c_str(), on_message, kept.get()) !=
      NATS_OK) {
    return nullptr;
  }
  NatsOwned<natsSubscription> out(made);
  const auto on_complete = [](void* closure) { delete static_cast<Hear*>(closure); };
  if (natsSubscription_SetOnCompleteCB(made, on_complete, kept.get()) == NATS_OK) {
    (void)kept.release();
  } else {
    natsSubscription_Unsubscribe(made);
    (void)kept.release();  // a callback may be running: a leak is better than use after free
    return nullptr;
  }
  return out;
}

void NatsHub::Impl::attach(Driven& driven) {
  const std::scoped_lock lock(mutex_);
  all_.push_back(&driven);
}

void NatsHub::Impl::detach(Driven& driven) {
  const std::scoped_lock lock(mutex_);
  std::erase(all_, &driven);
}

void NatsHub::Impl::wake() {
  // Without the lock, which is held while all are driven. A call between the thread's check and its
  // sleep is noticed kDriveEvery later.
  if (!awake_.exchange(true)) woken_.notify_one();
}

void NatsHub::Impl::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    woken_.wait_for(lock, kDriveEvery, [this] { return stop_ || awake_; });
    awake_ = false;
    for (Driven* driven : all_) driven->drive();
  }
}

void NatsHub::Impl::note_failure(const std::string& what, natsStatus status) {
  const char* const detail = nats_GetLastError(nullptr);
  const std::scoped_lock lock(counting_);
  reason_ = "cannot " + what + ": " + (detail != nullptr ? detail : natsStatus_GetText(status));
}

bool NatsHub::Impl::connected() const {
  return natsConnection_Status(connection_.get()) == NATS_CONN_STATUS_CONNECTED;
}

std::uint64_t NatsHub::Impl::life() const {
  std::array<char, 128> text{};
  if (!connected() ||
      natsConnection_GetConnectedServerId(connection_.get(), text.data(), text.size()) != NATS_OK) {
    return 0;
  }
  return consensus::SharedId::from_name(text.data()).low;
}

std::uint64_t NatsHub::Impl::reconnects() const {
  HubStatus out;
  count(out);
  return out.reconnects;
}

void NatsHub::Impl::count(HubStatus& out) const {
  const std::scoped_lock lock(counting_);
  if (natsConnection_GetStats(connection_.get(), statistics_.get()) != NATS_OK) return;
  natsStatistics_GetCounts(statistics_.get(), &out.messages_in, &out.bytes_in, &out.messages_out,
                           &out.bytes_out, &out.reconnects);
}

HubStatus NatsHub::Impl::status() const {
  HubStatus out;
  out.connected = connected();
  if (direct_ != nullptr) {
    out.direct_port = direct_->port();
    out.direct_unknown = direct_->unknown();
  }
  count(out);
  out.lost = lost_;
  out.slow = slow_;
  out.waiting = jobs_.waiting();
  const std::scoped_lock lock(counting_);
  out.reason = reason_;
  return out;
}

NatsHub::NatsHub(const HubOptions& options) : impl_(std::make_unique<Impl>(options)) {}
NatsHub::~NatsHub() = default;
HubStatus NatsHub::status() const { return impl_->status(); }

}  // namespace tandem::nats
