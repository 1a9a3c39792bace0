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

/// What the hub's thread and the application's share.
struct __attribute__((visibility("hidden"))) LedgerDesk {
  LedgerDesk(NatsHub::Impl& hub, const Subjects& subjects, const net::crypto::Secret& session_key)
      : store(hub, subjects, session_key) {}

  LedgerStore store;  ///< of the hub's thread alone
  std::atomic<bool> closed = false;
  std::atomic<std::size_t> waiting = 0;
  std::mutex mutex;
  std::vector<LedgerNews> news;

  void tell(LedgerNews::Kind kind, const LedgerRecord& record) {
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
    options.hub->impl().later([shared = shared, job = std::move(job)] {
      if (!shared->closed && !job()) return false;
      --shared->waiting;
      return true;
    });
  }

  void look(const Cell& cell) {
    ask([shared = shared.get(), cell] {
      return shared->store.look(cell, [shared](const LedgerRecord& record) {
        shared->tell(LedgerNews::Kind::Found, record);
      }) == LedgerStore::Result::Done;
    });
  }

  /// Where a body is looked for from now on.
  Cell cell_of(const LedgerRecord& record) const {
    const bool stays =
        record.revision > 0 &&
        distance_to(options.cells, record.cell, record.pose.position) <= options.cells.slack;
    return stays ? record.cell : cell_at(options.cells, record.pose.position);
  }

  const LedgerOptions options;
  std::shared_ptr<LedgerDesk> shared;
  std::map<Cell, NatsOwned<natsSubscription>> watched;
  std::map<SharedId, LedgerRecord> known;
  std::set<SharedId> writing;
  std::uint64_t reconnects = 0;
};

BodyLedger::BodyLedger(const LedgerOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}

BodyLedger::~BodyLedger() {
  // What was written last is worth a moment.
  const auto end = std::chrono::steady_clock::now() + kLeavePatience;
  while (impl_->shared->waiting > 0 && impl_->options.hub->status().connected &&
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
  const LedgerRecord* const before = known(id);
  LedgerRecord record = before != nullptr ? *before : LedgerRecord{.id = id};
  const Cell from = record.cell;
  record.keeper = keeper;
  record.pose = pose;
  record.twist = twist;
  if (!is_writable(record) || impl_->shared->waiting >= kMaxWaiting) return false;
  record.cell = impl_->cell_of(record);
  if (!impl_->writing.insert(id).second) return false;
  const Cell left = record.revision > 0 ? from : record.cell;
  impl_->ask([shared = impl_->shared.get(), record, left] {
    LedgerRecord written = record;
    const LedgerStore::Result result = shared->store.write(written, left);
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
  return at != impl_->known.end() ? &at->second : nullptr;
}

void BodyLedger::take(std::vector<LedgerNews>& out) {
  // What was told while there was no server is looked for.
  const std::uint64_t reconnects = impl_->options.hub->status().reconnects;
  if (reconnects != impl_->reconnects) {
    impl_->reconnects = reconnects;
    for (const auto& [cell, subscription] : impl_->watched) impl_->look(cell);
  }
  std::vector<LedgerNews> news;
  {
    const std::scoped_lock lock(impl_->shared->mutex);
    news.swap(impl_->shared->news);
  }
  for (LedgerNews& each : news) {
    if (each.kind != LedgerNews::Kind::Found) impl_->writing.erase(each.record.id);
    if (impl_->known.size() >= kMaxKnown && !impl_->known.contains(each.record.id)) continue;
    LedgerRecord& known = impl_->known[each.record.id];
    // News overtake each other; of two records the later one counts.
    if (each.record.revision < known.revision ||
        (each.record.revision == known.revision && each.kind == LedgerNews::Kind::Found)) {
      continue;
    }
    known = each.record;
    out.push_back(std::move(each));
  }
}

std::size_t BodyLedger::waiting() const { return impl_->shared->waiting; }

}  // namespace tandem::nats
