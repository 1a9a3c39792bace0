// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/nats_transport.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "nats_node.h"
#include "require.h"
#include "subjects.h"

namespace tandem::nats {

using consensus::PeerId;

namespace {

constexpr std::int64_t kTickEvery = 10'000'000;  // ns, if nobody drains
constexpr std::chrono::milliseconds kFlushStep{2};

std::int64_t steady_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::int64_t system_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::function<std::int64_t()> clock_of(const NatsOptions& options) {
  return options.steady ? options.steady : std::function<std::int64_t()>(steady_now);
}

std::shared_ptr<NatsHub> hub_of(const NatsOptions& options) {
  return options.hub != nullptr ? options.hub : std::make_shared<NatsHub>(options.server);
}

const NatsOptions& checked(const NatsOptions& options) {
  options.validate();
  return options;
}

}  // namespace

void NatsOptions::validate() const {
  if (hub == nullptr) server.validate();
  net::require(is_token(prefix), "NatsOptions", "prefix", prefix,
               "1 to 64 letters, digits, - and _");
  member.validate();
  cells.validate();
  net::require(direct_peers <= 256, "NatsOptions", "direct_peers", direct_peers, "in [0, 256]");
  for (const TrustedSpeaker& each : speakers) {
    net::require(each.peer != 0, "NatsOptions", "speakers", each.peer, "ids above 0");
  }
}

class __attribute__((visibility("hidden"))) NatsTransport::Impl final : public Driven {
 public:
  explicit Impl(const NatsOptions& options)
      : self(options.member.self),
        max_message_bytes(options.member.max_message_bytes),
        flush_timeout(options.member.flush_timeout),
        steady(clock_of(options)),
        begun(steady()),
        hub(hub_of(options)),
        node(options, hub, begun, options.steady ? 0 : system_now() - begun, steady) {
    hub->impl().attach(*this);
  }

  ~Impl() override {
    hub->impl().detach(*this);
    leave();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void drive() override {
    const std::int64_t now = steady();
    if (!posted.exchange(false) && now - ticked < kTickEvery) return;
    tick(now);
  }

  void tick(std::int64_t now) {
    const std::scoped_lock lock(mutex);
    ticked = now;
    node.tick(now);
  }

  /// Sends what was posted and announces that this peer leaves.
  void leave() {
    const auto end = std::chrono::steady_clock::now() + flush_timeout;
    const auto wait = [&] {
      std::this_thread::sleep_for(kFlushStep);
      tick(steady());
      return std::chrono::steady_clock::now() < end;
    };
    tick(steady());
    while (node.node().table().busy() && wait()) {
    }
    node.node().leave("left the session", steady());
    tick(steady());
    while (node.node().connections() > 0 && wait()) {
    }
  }

  /// Calls `use(node, now)` under the lock.
  template <class Use>
  auto with(Use&& use) {
    const std::scoped_lock lock(mutex);
    return use(node, steady());
  }

  const PeerId self;
  const std::size_t max_message_bytes;
  const std::chrono::milliseconds flush_timeout;
  const std::function<std::int64_t()> steady;
  const std::int64_t begun;
  const std::shared_ptr<NatsHub> hub;
  std::mutex mutex;
  NatsNode node;
  std::atomic<bool> posted = false;
  std::atomic<std::int64_t> ticked = 0;
};

NatsTransport::NatsTransport(const NatsOptions& options)
    : impl_(std::make_unique<Impl>(checked(options))) {}
NatsTransport::~NatsTransport() = default;

PeerId NatsTransport::self() const { return impl_->self; }

bool NatsTransport::post(PeerId to, std::span<const std::byte> bytes,
                         consensus::Delivery delivery) {
  const bool taken = impl_->with(
      [&](NatsNode& node, std::int64_t now) { return node.node().post(to, bytes, delivery, now); });
  impl_->posted = true;
  impl_->hub->impl().wake();
  return taken;
}

std::size_t NatsTransport::max_packet_bytes(consensus::Delivery delivery) const {
  if (delivery == consensus::Delivery::Reliable) return impl_->max_message_bytes;
  return impl_->with([](NatsNode& node, std::int64_t) { return node.node().max_state_bytes(); });
}

void NatsTransport::drain(std::vector<consensus::Packet>& out) {
  impl_->tick(impl_->steady());
  impl_->with([&](NatsNode& node, std::int64_t) { node.drain(out); });
}

void NatsTransport::drop(PeerId peer, const std::string& reason) {
  impl_->with([&](NatsNode& node, std::int64_t now) { node.node().drop(peer, reason, now); });
}

std::vector<consensus::PeerStatus> NatsTransport::peers() const {
  return impl_->with([](NatsNode& node, std::int64_t) { return node.node().peers(); });
}

void NatsTransport::list_peers(std::vector<consensus::PeerStatus>& out) const {
  impl_->with([&out](NatsNode& node, std::int64_t) { node.node().table().list(out); });
}

void NatsTransport::set_position(const pbd::Vec3& position) {
  if (!position.allFinite()) return;
  impl_->with([&](NatsNode& node, std::int64_t) { node.move(position); });
}

void NatsTransport::near_peers(std::vector<NearPeer>& out) const {
  impl_->with([&](const NatsNode& node, std::int64_t) { node.near_peers(out); });
}

bool NatsTransport::speaks(int level) const {
  return impl_->with(
      [level](const NatsNode& node, std::int64_t now) { return node.speaks(level, now); });
}

bool NatsTransport::set_summary(int level, std::span<const std::byte> content) {
  return impl_->with(
      [&](NatsNode& node, std::int64_t) { return node.set_summary(level, content); });
}

void NatsTransport::take_summaries(std::vector<CellSummary>& out) {
  impl_->with([&](NatsNode& node, std::int64_t) { node.take_summaries(out); });
}

void NatsTransport::poll() { impl_->tick(impl_->steady()); }

bool NatsTransport::change_group(std::span<const std::byte> signed_change) {
  return impl_->with([&](NatsNode& node, std::int64_t now) {
    return node.node().change_group(signed_change, now) == net::Credentials::Changed::Yes;
  });
}

std::uint64_t NatsTransport::group() const {
  return impl_->with([](NatsNode& node, std::int64_t) { return node.node().credentials().group; });
}

consensus::SessionTime NatsTransport::session_now() const {
  return impl_->with([](NatsNode& node, std::int64_t now) { return node.node().session_now(now); });
}

net::ClockStatus NatsTransport::clock() const {
  return impl_->with([](NatsNode& node, std::int64_t now) { return node.node().clock(now); });
}

NatsStatus NatsTransport::status() const {
  return impl_->with([](NatsNode& node, std::int64_t) { return node.status(); });
}

}  // namespace tandem::nats
