// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/body_ledger.h"

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "ledger_store.h"
#include "require.h"
#include "tandem/consensus/update.h"

namespace tandem::nats {

using consensus::SharedId;

struct StoredNews {
  LedgerNews::Kind kind{};
  StoredRecord stored;
};

/// Shared by the hub's thread and the application's.
struct __attribute__((visibility("hidden"))) LedgerDesk {
  LedgerDesk(NatsHub::Impl& hub, const Subjects& subjects, const net::crypto::Secret& session_key)
      : store(hub, subjects, session_key) {}

  LedgerStore store;  ///< used by the hub's thread only
  std::atomic<bool> closed = false;
  std::atomic<std::size_t> waiting = 0;
  std::atomic<std::uint64_t> rewritten = 0;
  std::mutex mutex;
  std::vector<StoredNews> news;
  std::set<Cell> asked;  ///< to be read

  void tell(LedgerNews::Kind kind, const StoredRecord& record) {
    const std::scoped_lock lock(mutex);
    news.push_back({kind, record});
  }
};

namespace {

constexpr std::chrono::seconds kLeavePatience{1};
constexpr std::size_t kMaxKnown = 1 << 17;  // bodies; a member may make up ids

bool is_writable(const LedgerRecord& record) {
  const consensus::StateUpdate state{
      .id = record.id, .pose = record.pose, .twist = record.twist, .stamp = 1};
  return consensus::check(state).ok();
}

}  // namespace

void LedgerOptions::validate() const {
  net::require(hub != nullptr, "LedgerOptions", "hub", std::string("none"), "a hub");
  net::require(is_token(prefix), "LedgerOptions", "prefix", prefix,
               "1 to 64 letters, digits, - and _");
  net::require(session_key != net::Key{}, "LedgerOptions", "session_key", std::string("zero"),
               "secret");
  cells.validate();
}

class __attribute__((visibility("hidden"))) BodyLedger::Impl {
 public:
  explicit Impl(const LedgerOptions& from)
      : options(from),
        shared(std::make_shared<LedgerDesk>(
            options.hub->impl(), Subjects(options.prefix, options.scene_hash, options.cells),
            net::crypto::Secret(options.session_key))) {}

  void ask(std::function<bool()> job) {
    ++shared->waiting;
    options.hub->impl().jobs().add(shared.get(), [shared = shared, job = std::move(job)] {
      if (!shared->closed && !job()) return false;
      --shared->waiting;
      return true;
    });
  }

  void look(const Cell& cell) {
    {
      const std::scoped_lock lock(shared->mutex);
      if (!shared->asked.insert(cell).second) return;
    }
    ask([shared = shared.get(), cell] {
      {
        const std::scoped_lock lock(shared->mutex);
        shared->asked.erase(cell);  // later records are requested again
      }
      const auto tell = [shared](const StoredRecord& record) {
        shared->tell(LedgerNews::Kind::Found, record);
      };
      if (shared->store.look(cell, tell) == LedgerStore::Result::Done) return true;
      const std::scoped_lock lock(shared->mutex);
      return !shared->asked.insert(cell).second;  // already requested: that request reads it
    });
  }

  /// A server that was killed may have lost acknowledged records. Their writers, and the peers that
  /// watch their cells, write them again unless there are later ones.
  void write_again() {
    std::vector<StoredRecord> all;
    for (const auto& [id, each] : known) {
      if (each.own || watched.contains(each.stored.record.cell)) all.push_back(each.stored);
    }
    const std::uint64_t turn = ++shared->rewritten;
    ask([shared = shared.get(), turn, all = std::move(all)]() mutable {
      if (turn != shared->rewritten) return true;  // superseded by a later rewrite
      for (; !all.empty(); all.pop_back()) {
        StoredRecord now = all.back();
        if (shared->store.write(now, all.back()) == LedgerStore::Result::NoServer) return false;
        shared->tell(LedgerNews::Kind::Found, now);
      }
      return true;
    });
  }

  /// The cell in which a body is found from now on.
  Cell cell_of(const LedgerRecord& record) const {
    const bool stays =
        record.revision > 0 &&
        distance_to(options.cells, record.cell, record.pose.position) <= options.cells.slack;
    return stays ? record.cell : cell_at(options.cells, record.pose.position);
  }

  const LedgerOptions options;
  std::shared_ptr<LedgerDesk> shared;
  std::map<Cell, NatsOwned<natsSubscription>> watched;
  struct Known {
    StoredRecord stored;
    bool own = false;  ///< written by this object
  };
  std::map<SharedId, Known> known;
  net::crypto::Random random = net::crypto::system_random();
  std::set<SharedId> writing;
  std::uint64_t reconnects = 0;
};

BodyLedger::BodyLedger(const LedgerOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}

BodyLedger::~BodyLedger() {
  // Wait briefly for the last writes.
  const auto end = std::chrono::steady_clock::now() + kLeavePatience;
  while (impl_->shared->waiting > 0 && impl_->options.hub->impl().connected() &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  impl_->shared->closed = true;
}

void BodyLedger::watch(const Cell& cell) {
  if (cell.level != 0 || impl_->watched.contains(cell)) return;
  impl_->watched[cell] = impl_->options.hub->impl().subscribe(
      impl_->shared->store.news(cell),
      [shared = impl_->shared, store = &impl_->shared->store](std::span<const std::byte> bytes) {
        if (const auto record = store->read_news(bytes)) {
          shared->tell(LedgerNews::Kind::Found, *record);
        }
      });
  impl_->look(cell);
}

void BodyLedger::unwatch(const Cell& cell) { impl_->watched.erase(cell); }

bool BodyLedger::write(const SharedId& id, consensus::PeerId keeper, const pbd::Pose& pose,
                       const pbd::Twist& twist) {
  const auto at = impl_->known.find(id);
  const StoredRecord before =
      at != impl_->known.end() ? at->second.stored : StoredRecord{.record = {.id = id}};
  StoredRecord next = before;
  next.record.keeper = keeper;
  next.record.pose = pose;
  next.record.twist = twist;
  if (!is_writable(next.record) || impl_->shared->waiting >= kMaxWaiting) return false;
  next.record.cell = impl_->cell_of(next.record);
  next.record.revision += 1;
  impl_->random({reinterpret_cast<std::uint8_t*>(&next.token), sizeof next.token});
  if (!impl_->writing.insert(id).second) return false;
  impl_->ask([shared = impl_->shared.get(), next, before] {
    StoredRecord written = next;
    const LedgerStore::Result result = shared->store.write(written, before);
    if (result == LedgerStore::Result::NoServer) return false;
    shared->tell(
        result == LedgerStore::Result::Done ? LedgerNews::Kind::Written : LedgerNews::Kind::Refused,
        written);
    return true;
  });
  return true;
}

const LedgerRecord* BodyLedger::known(const SharedId& id) const {
  const auto at = impl_->known.find(id);
  return at != impl_->known.end() ? &at->second.stored.record : nullptr;
}

void BodyLedger::take(std::vector<LedgerNews>& out) {
  // After a reconnect: read what was written meanwhile, and write again what the server has lost.
  const std::uint64_t reconnects = impl_->options.hub->impl().reconnects();
  if (reconnects != impl_->reconnects) {
    impl_->reconnects = reconnects;
    impl_->write_again();
    for (const auto& [cell, subscription] : impl_->watched) impl_->look(cell);
  }
  std::vector<StoredNews> news;
  {
    const std::scoped_lock lock(impl_->shared->mutex);
    news.swap(impl_->shared->news);
  }
  for (const auto& [kind, stored] : news) {
    const SharedId& id = stored.record.id;
    if (kind != LedgerNews::Kind::Found) impl_->writing.erase(id);
    if (stored.record.revision == 0) continue;
    if (impl_->known.size() >= kMaxKnown && !impl_->known.contains(id)) continue;
    Impl::Known& known = impl_->known[id];
    // News may overtake each other; the later of two records counts.
    if (stored.version() < known.stored.version()) continue;
    const bool is_known = stored.version() == known.stored.version();
    known.stored = stored;
    if (is_known && kind == LedgerNews::Kind::Found) continue;
    known.own = kind == LedgerNews::Kind::Written;
    out.push_back({kind, stored.record});
  }
}

std::size_t BodyLedger::waiting() const { return impl_->shared->waiting; }

}  // namespace tandem::nats
