// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// No body is lost and none is in two places, with any writers and any fault of the server.
#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "ledger_wire.h"
#include "nats/peers.h"
#include "net/protocol_support.h"
#include "tandem/nats/body_ledger.h"
#include "tandem/nats/cell_events.h"
#include "tandem/pbd/random.h"

namespace tandem::nats::ledger_test {
namespace {

using namespace testing;
using consensus::SharedId;
using Kind = LedgerNews::Kind;

LedgerOptions ledger_options(std::uint16_t port) {
  LedgerOptions out;
  out.hub = std::make_shared<NatsHub>(HubOptions{.servers = {{"127.0.0.1", port}}});
  out.scene_hash = 42;
  out.session_key = session_key();
  out.cells = {.edge = 4.0, .levels = 3, .near = 4.0, .slack = 0.5};
  return out;
}

pbd::Pose at(double x, double y) { return {Vec3(x, y, 0.5), pbd::Quat::Identity()}; }

SharedId body(int number) { return SharedId::from_name("body/" + std::to_string(number)); }

/// Waits for the news of one body.
std::vector<LedgerNews> news_of(BodyLedger& ledger, const SharedId& id) {
  std::vector<LedgerNews> all;
  const auto is_his = [&](const LedgerNews& each) { return each.record.id == id; };
  REQUIRE(eventually([&] {
    ledger.take(all);
    return std::ranges::any_of(all, is_his);
  }));
  std::erase_if(all, [&](const LedgerNews& each) { return !is_his(each); });
  return all;
}

/// Bodies found by a new look at all cells.
std::map<SharedId, std::vector<LedgerRecord>> census(const LedgerOptions& options, int cells) {
  BodyLedger ledger(options);
  for (int x = -1; x <= cells; ++x) {
    for (int y = -1; y <= cells; ++y) ledger.watch({0, x, y});
  }
  std::map<SharedId, std::vector<LedgerRecord>> out;
  REQUIRE(eventually([&] { return ledger.waiting() == 0; }, std::chrono::seconds(60)));
  std::vector<LedgerNews> all;
  ledger.take(all);
  for (const LedgerNews& each : all) out[each.record.id].push_back(each.record);
  return out;
}

TEST_CASE("ledger: where the server keeps no events, records are written, and it is told why",
          "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  const LedgerOptions options = ledger_options(server.port());
  CellEventOptions events{.hub = options.hub,
                          .scene_hash = options.scene_hash,
                          .session_key = options.session_key,
                          .cells = options.cells,
                          .self = 1};
  CellEvents first(events);
  first.set_position(Vec3(1.0, 1.0, 0.0));
  REQUIRE(eventually([&] { return first.waiting() == 0; }));
  CHECK(options.hub->status().reason.empty());
  // Another member keeps them for another time: the stream that is there is not his.
  events.self = 2;
  events.kept = std::chrono::seconds(60);
  events.hub = ledger_options(server.port()).hub;
  CellEvents second(events);
  second.set_position(Vec3(1.0, 1.0, 0.0));
  for (int i = 0; i < 100; ++i) {
    REQUIRE(second.send(Vec3(1.0, 1.0, 0.0), "door", numbered(0), 7));
  }
  REQUIRE(eventually([&] { return !events.hub->status().reason.empty(); }));
  LedgerOptions same_hub = options;
  same_hub.hub = events.hub;
  BodyLedger ledger(same_hub);
  CHECK(ledger.write(body(1), 7, at(1.0, 1.0), {}));
  CHECK(news_of(ledger, body(1)).back().kind == Kind::Written);
  CHECK(events.hub->status().reason.find("keep the stream") != std::string::npos);
  // Nothing piles up: one of a hundred words is asked for.
  CHECK(second.waiting() > 0);
  CHECK(second.waiting() < 30);
}

TEST_CASE("ledger: a newcomer to a cell finds the bodies left there", "[nats]") {
  if (!has_server()) return;
  Server server;
  const LedgerOptions options = ledger_options(server.port());
  {
    BodyLedger first(options);
    CHECK(first.write(body(1), 7, at(1.0, 1.0), {}));
    CHECK_FALSE(first.write(body(1), 7, at(2.0, 1.0), {}));  // one at a time
    const auto news = news_of(first, body(1));
    CHECK(news.back().kind == Kind::Written);
    CHECK(first.known(body(1))->cell == Cell{0, 0, 0});
  }
  BodyLedger second(ledger_options(server.port()));
  second.watch({0, 0, 0});
  const LedgerRecord found = news_of(second, body(1)).back().record;
  CHECK(found.keeper == 7);
  CHECK(found.pose.position == Vec3(1.0, 1.0, 0.5));
  // It goes on a little over the border, and then further.
  CHECK(second.write(body(1), 8, at(4.3, 1.0), {}));
  CHECK(news_of(second, body(1)).back().record.cell == Cell{0, 0, 0});
  CHECK(second.write(body(1), 8, at(4.6, 1.0), {}));
  CHECK(news_of(second, body(1)).back().record.cell == Cell{0, 1, 0});
  BodyLedger third(options);
  third.watch({0, 1, 0});
  CHECK(news_of(third, body(1)).back().record.keeper == 8);
  const auto all = census(options, 3);
  CHECK(all.size() == 1);
  CHECK(all.at(body(1)).size() == 1);
}

TEST_CASE("ledger: if two take a body at once, one is refused and told the keeper", "[nats]") {
  if (!has_server()) return;
  Server server;
  std::vector<std::unique_ptr<BodyLedger>> all;
  for (int i = 0; i < 4; ++i) {
    all.push_back(std::make_unique<BodyLedger>(ledger_options(server.port())));
  }
  CHECK(all[0]->write(body(1), 0, at(1.0, 1.0), {}));
  news_of(*all[0], body(1));
  for (int i = 1; i < 4; ++i) {
    all[static_cast<std::size_t>(i)]->watch({0, 0, 0});
    news_of(*all[static_cast<std::size_t>(i)], body(1));
  }
  for (int round = 0; round < 20; ++round) {
    int written = 0;
    std::set<PeerId> keepers;
    for (int i = 0; i < 4; ++i) {
      REQUIRE(all[static_cast<std::size_t>(i)]->write(
          body(1), static_cast<PeerId>(10 * round + i + 1), at(1.0, 1.0), {}));
    }
    for (auto& each : all) {
      std::vector<LedgerNews> news;
      REQUIRE(eventually([&] { return each->waiting() == 0; }));
      each->take(news);
      for (const LedgerNews& one : news) written += one.kind == Kind::Written ? 1 : 0;
    }
    // News that are on their way still.
    REQUIRE(eventually([&] {
      keepers.clear();
      std::vector<LedgerNews> news;
      for (auto& each : all) {
        each->take(news);
        keepers.insert(each->known(body(1))->keeper);
      }
      return keepers.size() == 1;
    }));
    CHECK(written == 1);
  }
}

/// Four keepers who are at odds over a hundred bodies.
class Crowd {
 public:
  static constexpr int kBodies = 100;
  static constexpr int kCells = 6;

  Crowd(std::uint16_t port, std::uint64_t seed) : dice_(seed) {
    for (int k = 0; k < 4; ++k) {
      keepers_.push_back(std::make_unique<BodyLedger>(ledger_options(port)));
      for (int x = 0; x < kCells; ++x) {
        for (int y = 0; y < kCells; ++y) keepers_.back()->watch({0, x, y});
      }
    }
    for (int i = 0; i < kBodies; ++i) REQUIRE(keepers_[0]->write(body(i), 1, anywhere(), {}));
  }

  /// Each takes any body at any time, so that they are often refused, until so many were written.
  void cross(int crossings) {
    std::vector<LedgerNews> news;
    while (crossings_ < crossings) {
      for (auto& keeper : keepers_) {
        news.clear();
        keeper->take(news);
        for (const LedgerNews& each : news) {
          const Cell& cell = each.record.cell;
          CHECK((cell.x >= 0 && cell.x < kCells && cell.y >= 0 && cell.y < kCells));
          if (each.kind == Kind::Written) ++crossings_;
          if (each.kind == Kind::Refused) ++refused_;
        }
        for (int n = 0; n < 8; ++n) {
          const SharedId id = body(static_cast<int>(dice_.below(kBodies)));
          if (keeper->known(id) != nullptr && keeper->waiting() < 32) {
            keeper->write(id, 1 + dice_.below(4), anywhere(), {});
          }
        }
      }
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }
  int refused() const { return refused_; }

  /// Whether all keepers know of each body what the server has.
  bool agrees_with(const std::map<SharedId, std::vector<LedgerRecord>>& found) {
    std::vector<LedgerNews> news;
    for (auto& keeper : keepers_) {
      if (keeper->waiting() > 0) return false;
      keeper->take(news);
      for (const auto& [id, records] : found) {
        const LedgerRecord* const known = keeper->known(id);
        if (known == nullptr || known->revision != records.front().revision ||
            known->keeper != records.front().keeper ||
            known->pose.position != records.front().pose.position) {
          return false;
        }
      }
    }
    return true;
  }
  void settle() {
    for (auto& keeper : keepers_) {
      REQUIRE(eventually([&] { return keeper->waiting() == 0; }));
    }
  }

 private:
  pbd::Pose anywhere() {
    return at(dice_.uniform(0.0, 4.0 * kCells), dice_.uniform(0.0, 4.0 * kCells));
  }

  pbd::SplitMix64 dice_;
  std::vector<std::unique_ptr<BodyLedger>> keepers_;
  int crossings_ = 0;
  int refused_ = 0;
};

TEST_CASE("ledger: ten thousand crossings lose and double no body despite a killed server",
          "[nats][fault]") {
  if (!has_server()) return;
  const std::uint64_t seed = GENERATE(3U, 4U, 5U);
  CAPTURE(seed);
  Server server;
  Crowd crowd(server.port(), seed);
  crowd.cross(3000);
  server.kill();
  server.start();
  crowd.cross(5000);
  server.keep();
  crowd.cross(7000);
  server.lose();  // two thousand records that somebody was told are written
  server.start();
  crowd.cross(10000);
  crowd.settle();
  CHECK(crowd.refused() > 0);
  const auto found = census(ledger_options(server.port()), Crowd::kCells);
  CHECK(found.size() == Crowd::kBodies);
  CHECK(std::ranges::all_of(found, [](const auto& entry) { return entry.second.size() == 1; }));
  CHECK(eventually([&] { return crowd.agrees_with(found); }));
}

TEST_CASE("ledger: bodies that nobody touches are written again where the server has lost them",
          "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  const bool some = GENERATE(false, true);
  CAPTURE(some);
  Crowd crowd(server.port(), 3);
  crowd.cross(200);
  if (some) server.keep();
  crowd.cross(1000);
  crowd.settle();
  const auto before = census(ledger_options(server.port()), Crowd::kCells);
  REQUIRE(before.size() == Crowd::kBodies);
  REQUIRE(eventually([&] { return crowd.agrees_with(before); }));
  server.lose();
  server.start();
  // Whether the server has what everybody knew before it was lost.
  const auto is_back = [&] {
    crowd.agrees_with(before);
    const auto found = census(ledger_options(server.port()), Crowd::kCells);
    return found.size() == Crowd::kBodies && crowd.agrees_with(found) && crowd.agrees_with(before);
  };
  CHECK(eventually(is_back));
}

TEST_CASE("ledger: a body without a keeper at the server gets exactly one", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  BodyLedger first(ledger_options(server.port()));
  BodyLedger second(ledger_options(server.port()));
  const Cell cell{0, 0, 0};
  std::vector<LedgerNews> news;
  const auto agree = [&](int revision) {
    REQUIRE(eventually([&] {
      first.take(news);
      second.take(news);
      return first.waiting() + second.waiting() == 0 && first.known(body(1)) != nullptr &&
             second.known(body(1)) != nullptr &&
             first.known(body(1))->keeper == second.known(body(1))->keeper &&
             first.known(body(1))->revision == second.known(body(1))->revision;
    }));
    const auto found = census(ledger_options(server.port()), 1);
    REQUIRE(found.contains(body(1)));
    const LedgerRecord& record = found.at(body(1)).front();
    CHECK(record.keeper == first.known(body(1))->keeper);
    CHECK(record.revision == static_cast<std::uint64_t>(revision));
    return record.keeper;
  };
  second.watch(cell);
  first.watch(cell);
  REQUIRE(first.write(body(1), 1, at(1.0, 1.0), {}));
  agree(1);
  for (int round = 1; round <= 6; ++round) {
    server.keep();
    // The second takes it, of which the first does not hear and the server forgets.
    first.unwatch(cell);
    REQUIRE(second.write(body(1), 2, at(2.0, 1.0), {}));
    news_of(second, body(1));
    server.lose();
    first.watch(cell);
    const bool takes_too = round > 2;
    if (takes_too) REQUIRE(first.write(body(1), 1, at(1.0, 2.0), {}));
    server.start();
    const PeerId keeper = agree(1 + round);
    if (!takes_too) CHECK(keeper == 2);
  }
}

TEST_CASE("ledger: writes during an outage of the server are made up for", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  const LedgerOptions options = ledger_options(server.port());
  BodyLedger ledger(options);
  CHECK(ledger.write(body(1), 7, at(1.0, 1.0), {}));
  news_of(ledger, body(1));
  server.kill();
  CHECK(ledger.write(body(1), 7, at(9.0, 1.0), {}));
  CHECK(ledger.write(body(2), 7, at(9.0, 9.0), {}));
  server.start();
  CHECK(news_of(ledger, body(2)).back().kind == Kind::Written);
  CHECK(census(options, 3).size() == 2);
}

TEST_CASE("ledger: a record opens for its body alone, and no number gets in that cannot be",
          "[nats][fault]") {
  const auto key = protocol::secret(1);
  const LedgerRecord record{
      .id = body(1), .cell = {0, 3, -4}, .keeper = 9, .pose = at(1.0, 2.0), .revision = 1};
  std::vector<std::byte> bytes;
  seal_record(record, 5, key, protocol::seeded(2), bytes);
  const auto opened = open_record(bytes, body(1), key);
  REQUIRE(opened.has_value());
  CHECK(opened->token == 5);
  CHECK(opened->record.cell == record.cell);
  CHECK(opened->record.pose.position == record.pose.position);
  CHECK_FALSE(open_record(bytes, body(2), key).has_value());
  CHECK_FALSE(open_record(bytes, body(1), protocol::secret(2)).has_value());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto changed = bytes;
    changed[i] ^= std::byte{1};
    CHECK_FALSE(open_record(changed, body(1), key).has_value());
    CHECK_FALSE(open_record(std::span(bytes).first(i), body(1), key).has_value());
  }
  LedgerRecord bad = record;
  bad.pose.position.x() = std::numeric_limits<double>::quiet_NaN();
  seal_record(bad, 5, key, protocol::seeded(3), bytes);
  CHECK_FALSE(open_record(bytes, body(1), key).has_value());
}

}  // namespace
}  // namespace tandem::nats::ledger_test
