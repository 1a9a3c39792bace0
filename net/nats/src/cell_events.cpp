// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/cell_events.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "event_store.h"
#include "group_seal.h"
#include "require.h"

namespace tandem::nats {

using consensus::PeerId;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLastWords{1};
/// Interval of reading the cells in turn, as notifications can be lost.
constexpr std::chrono::milliseconds kLookEvery{500};
constexpr std::size_t kMaxLogs = 4096;

}  // namespace

struct SaidEvent {
  Cell cell;
  std::uint64_t number = 0;
  std::string name;
  std::vector<std::byte> sealed;
  Clock::time_point at;
};

/// Shared by the hub's threads and the application's.
struct __attribute__((visibility("hidden"))) EventDesk {
  EventDesk(NatsHub::Impl& through, const Subjects& subjects, const CellEventOptions& options)
      : hub(through), store(through, subjects, options) {}

  NatsHub::Impl& hub;

  EventStore store;               ///< used by the hub's thread only
  std::map<Cell, EventLog> logs;  ///< used by the hub's thread only
  std::atomic<bool> closed = false;
  std::atomic<std::size_t> waiting = 0;
  std::mutex mutex;
  std::set<Cell> asked;  ///< to be read
  bool write_asked = false;
  std::vector<CellEvent> news;
  std::set<Cell> left;                                ///< not read to the end, as `news` was full
  std::deque<std::shared_ptr<const SaidEvent>> kept;  ///< own, by ascending number
  std::uint64_t written = 0;                          ///< last event on the server
  std::uint64_t life = 0;                             ///< life of the server

  /// The next event to write; null: none. A restarted server may have lost any event: then all are
  /// written again, in order.
  std::shared_ptr<const SaidEvent> next_to_write(std::uint64_t now) {
    const std::scoped_lock lock(mutex);
    if (life != now) written = 0;
    life = now;
    const auto at =
        std::ranges::find_if(kept, [this](const auto& said) { return said->number > written; });
    write_asked = at != kept.end();
    return write_asked ? *at : nullptr;
  }
  /// On the hub's thread.
  bool write() {
    for (;;) {
      const std::uint64_t now = hub.life();
      if (now == 0) return false;
      const auto said = next_to_write(now);
      if (said == nullptr) return true;
      if (!store.write(said->cell, said->name, said->sealed)) return false;
      const std::scoped_lock lock(mutex);
      written = said->number;
    }
  }

  /// On the hub's thread.
  bool read(const Cell& cell) {
    {
      const std::scoped_lock lock(mutex);
      asked.erase(cell);  // later events are requested again
    }
    if (read_on(cell)) return true;
    const std::scoped_lock lock(mutex);
    return !asked.insert(cell).second;  // already requested: that request reads it
  }
  bool read_on(const Cell& cell) {
    if (!has_room(cell)) return true;
    if (logs.size() >= kMaxLogs && !logs.contains(cell)) logs.erase(logs.begin());
    return store.read(cell, logs[cell], [this, &cell](const CellEvent& event) {
      {
        const std::scoped_lock lock(mutex);
        news.push_back(event);
      }
      return has_room(cell);
    });
  }
  /// If there is no room, the cell is read once some has been made.
  bool has_room(const Cell& cell) {
    const std::scoped_lock lock(mutex);
    if (news.size() < CellEvents::kMaxUntaken) return true;
    left.insert(cell);
    return false;
  }
};

void CellEventOptions::validate() const {
  net::require(hub != nullptr, "CellEventOptions", "hub", std::string("none"), "a hub");
  net::require(is_token(prefix), "CellEventOptions", "prefix", prefix,
               "1 to 64 letters, digits, - and _");
  net::require(session_key != net::Key{}, "CellEventOptions", "session_key", std::string("zero"),
               "secret");
  net::require(self != 0, "CellEventOptions", "self", self, "not 0");
  net::require(kept >= std::chrono::seconds(1) && kept <= std::chrono::hours(24),
               "CellEventOptions", "kept", kept.count(), "in [1 s, 1 day]");
  cells.validate();
}

class __attribute__((visibility("hidden"))) CellEvents::Impl {
 public:
  explicit Impl(const CellEventOptions& from)
      : options(from),
        desk(std::make_shared<EventDesk>(
            options.hub->impl(), Subjects(options.prefix, options.scene_hash, options.cells),
            options)),
        random(net::crypto::system_random()),
        session_key(options.session_key),
        sealer(options.self, 0, random) {
    random({reinterpret_cast<std::uint8_t*>(&source), sizeof source});
  }

  /// On the application's thread or the client library's.
  static void ask(NatsHub::Impl& hub, const std::shared_ptr<EventDesk>& desk,
                  std::function<bool()> job) {
    ++desk->waiting;
    hub.jobs().add(desk.get(), [desk, job = std::move(job)] {
      if (!desk->closed && !job()) return false;
      --desk->waiting;
      return true;
    });
  }
  static void look(NatsHub::Impl& hub, const std::shared_ptr<EventDesk>& desk, const Cell& cell) {
    {
      const std::scoped_lock lock(desk->mutex);
      if (!desk->asked.insert(cell).second) return;
    }
    ask(hub, desk, [desk = desk.get(), cell] { return desk->read(cell); });
  }

  void listen(const Cell& cell) {
    NatsHub::Impl& hub = options.hub->impl();
    listened[cell] = hub.subscribe(
        desk->store.news(cell),
        [hub = &hub, desk = desk, cell](std::span<const std::byte>) { look(*hub, desk, cell); });
    look(hub, desk, cell);
  }

  void write() {
    {
      const std::scoped_lock lock(desk->mutex);
      if (std::exchange(desk->write_asked, true)) return;
    }
    ask(options.hub->impl(), desk, [desk = desk.get()] { return desk->write(); });
  }

  const CellEventOptions options;
  const std::shared_ptr<EventDesk> desk;
  net::crypto::Random random;
  net::crypto::Secret session_key;
  GroupSealer sealer;
  std::uint64_t source = 0;
  std::uint64_t number = 0;
  std::map<Cell, NatsOwned<natsSubscription>> listened;
  std::uint64_t reconnects = 0;
  Clock::time_point look_due = Clock::now();
  Cell looked{};  ///< last cell read in turn
};

CellEvents::CellEvents(const CellEventOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}

CellEvents::~CellEvents() {
  impl_->listened.clear();
  // Wait briefly for the last events.
  const auto end = Clock::now() + kLastWords;
  while (impl_->desk->waiting > 0 && impl_->options.hub->impl().connected() && Clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  impl_->desk->closed = true;
}

void CellEvents::set_position(const pbd::Vec3& position) {
  if (!position.allFinite()) return;
  const CellOptions& cells = impl_->options.cells;
  std::erase_if(impl_->listened, [&](const auto& entry) {
    return distance_to(cells, entry.first, position) > cells.near + cells.slack;
  });
  const pbd::Vec3 corner(cells.near, cells.near, 0.0);
  const Cell low = cell_at(cells, position - corner);
  const Cell high = cell_at(cells, position + corner);
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      const Cell cell{0, x, y};
      if (!impl_->listened.contains(cell)) impl_->listen(cell);
    }
  }
}

bool CellEvents::send(const pbd::Vec3& position, std::string_view topic,
                      std::span<const std::byte> payload, consensus::SessionTime stamp) {
  if (!position.allFinite() || topic.size() > kMaxTopicBytes || payload.size() > kMaxPayloadBytes) {
    return false;
  }
  const std::shared_ptr<EventDesk>& desk = impl_->desk;
  {
    const std::scoped_lock lock(desk->mutex);
    auto& kept = desk->kept;
    while (!kept.empty() && Clock::now() - kept.front()->at > impl_->options.kept) kept.pop_front();
    if (kept.size() >= kMaxKept) return false;
  }
  NumberedEvent event{.source = impl_->source, .number = ++impl_->number, .event = {}};
  event.event = {.cell = cell_at(impl_->options.cells, position),
                 .from = impl_->options.self,
                 .stamp = stamp,
                 .topic = std::string(topic),
                 .payload = {payload.begin(), payload.end()}};
  std::vector<std::byte> plain;
  encode(event, plain);
  auto said = std::make_shared<SaidEvent>(SaidEvent{.cell = event.event.cell,
                                                    .number = event.number,
                                                    .name = hex(event.source) + hex(event.number),
                                                    .sealed = {},
                                                    .at = Clock::now()});
  impl_->sealer.seal(plain, impl_->session_key, static_cast<std::int64_t>(event.number),
                     said->sealed);
  {
    const std::scoped_lock lock(desk->mutex);
    desk->kept.push_back(said);
  }
  impl_->write();
  return true;
}

void CellEvents::take(std::vector<CellEvent>& out) {
  NatsHub::Impl& hub = impl_->options.hub->impl();
  // After a reconnect: send again what the server has lost, and read what was sent meanwhile.
  if (const std::uint64_t now = hub.reconnects(); now != impl_->reconnects) {
    impl_->reconnects = now;
    impl_->write();
    for (const auto& [cell, subscription] : impl_->listened) Impl::look(hub, impl_->desk, cell);
  }
  if (Clock::now() >= impl_->look_due && !impl_->listened.empty()) {
    impl_->look_due = Clock::now() + kLookEvery;
    auto next = impl_->listened.upper_bound(impl_->looked);
    if (next == impl_->listened.end()) next = impl_->listened.begin();
    impl_->looked = next->first;
    Impl::look(hub, impl_->desk, next->first);
  }
  std::set<Cell> left;
  {
    const std::scoped_lock lock(impl_->desk->mutex);
    std::ranges::move(impl_->desk->news, std::back_inserter(out));
    impl_->desk->news.clear();
    left.swap(impl_->desk->left);
  }
  for (const Cell& cell : left) Impl::look(hub, impl_->desk, cell);
}

std::size_t CellEvents::waiting() const { return impl_->desk->waiting; }

std::uint64_t CellEvents::refused() const { return impl_->desk->store.refused(); }

}  // namespace tandem::nats
