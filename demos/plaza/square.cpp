// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "plaza/square.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include "tandem/net/clock.h"
#include "tandem/net/session.h"

namespace tandem::demos {

namespace {

constexpr std::chrono::seconds kServerPatience{20};
constexpr double kSettle = 3.0;     // s: warm-up without measurement
constexpr double kLookEvery = 0.1;  // s
constexpr double kMoving = 0.05;    // m/s
constexpr double kCloseBy = 0.7;    // of reach(): both have had the body for a while

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::shared_ptr<nats::NatsHub> connect(const PlazaOptions& options) {
  nats::HubOptions hub;
  hub.servers = {net::parse_host_port(options.server)};
  hub.driven = false;
  if (options.direct > 0) {
    hub.direct.emplace();
    // Clients of a server on this machine are on this machine too.
    if (hub.servers.front().host == "127.0.0.1") hub.direct->listen_address = "127.0.0.1";
  }
  auto out = std::make_shared<nats::NatsHub>(hub);
  const auto end = std::chrono::steady_clock::now() + kServerPatience;
  while (!out->status().connected) {
    if (std::chrono::steady_clock::now() > end) {
      throw std::runtime_error("no NATS server at " + options.server);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return out;
}

void wait_for(const nats::BodyLedger& ledger) {
  while (ledger.waiting() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

std::int64_t SquareClock::wall() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Steady::now().time_since_epoch())
      .count();
}

std::int64_t SquareClock::now() const {
  return base_ + std::clamp<std::int64_t>(wall() - began_, 0, step_);
}

std::int64_t SquareClock::begin_step() {
  const std::int64_t due = began_ + step_;
  const std::int64_t early = due - wall();
  if (early > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(early));
  // This order lets a concurrent reader see the end of the step before.
  base_ += step_;
  began_ = wall();
  return base_;
}

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto at = [&](double part) {
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  };
  return {at(0.5), at(0.95), at(0.99), values.back()};
}

Square::Square(const PlazaOptions& options)
    : options_(options), clock_(static_cast<std::int64_t>(1e9 / options.step_hz)) {}

Square::~Square() = default;

void Square::lay_out() {
  const auto hub = connect(options_);
  nats::BodyLedger ledger({.hub = hub,
                           .scene_hash = options_.scene_hash(),
                           .session_key = plaza_key(),
                           .cells = options_.cells()});
  for (std::size_t i = 0; i < options_.bodies; ++i) {
    // Refused if earlier participants have moved them.
    ledger.write(PlazaBody::id(i), 0, {.position = start_of_body(options_, i)}, {});
  }
  wait_for(ledger);
}

void Square::arrive() {
  const bool nats = options_.wire == PlazaWire::Nats;
  if (nats) lay_out();
  for (std::size_t i = 0; i < options_.people; ++i) {
    VisitorLink link{.hub = nullptr, .clock = [this] { return clock_.now(); }, .meet = {}};
    if (nats) {
      if (i % options_.per_hub == 0) hubs_.push_back(connect(options_));
      link.hub = hubs_.back();
    } else if (i > 0) {
      link.meet = people_.front()->port();
    }
    people_.push_back(std::make_unique<Visitor>(options_, i, link));
  }
}

void Square::look() {
  std::map<consensus::SharedId, std::vector<const Visitor*>> who;
  for (const auto& visitor : people_) {
    if (visitor->custody() == nullptr) {
      for (std::size_t i = 0; i < options_.bodies; ++i) {
        who[PlazaBody::id(i)].push_back(visitor.get());
      }
      continue;
    }
    for (const auto& [id, local] : visitor->custody()->local()) {
      const pbd::Vec3& at = visitor->copy_of(id)->pose.position;
      const double apart = (at - visitor->feet()).head<2>().norm();
      if (apart < kCloseBy * options_.reach()) who[id].push_back(visitor.get());
    }
  }
  for (const auto& [id, have] : who) {
    for (std::size_t i = 0; i < have.size(); ++i) {
      for (std::size_t k = i + 1; k < have.size(); ++k) {
        if (!have[i]->is_connected(have[k]->id())) continue;
        const pbd::BodyState& a = *have[i]->copy_of(id);
        const pbd::BodyState& b = *have[k]->copy_of(id);
        const bool moves = std::max(a.twist.linear.norm(), b.twist.linear.norm()) > kMoving;
        (moves ? moving_ : resting_).push_back(1e3 * (a.pose.position - b.pose.position).norm());
      }
    }
  }
}

void Square::tell(double time) {
  double connected = 0.0;
  double simulated = 0.0;
  bool served = options_.wire == PlazaWire::Udp;
  for (const auto& visitor : people_) {
    connected += static_cast<double>(visitor->connected());
    if (visitor->custody() != nullptr) {
      simulated += static_cast<double>(visitor->custody()->local().size());
    }
  }
  for (const auto& hub : hubs_) served = served || hub->status().connected;
  const double people = static_cast<double>(people_.size());
  const Spread moving = spread_of(moving_);
  const Spread resting = spread_of(resting_);
  if (!options_.quiet) {
    std::fprintf(stderr,
                 "%6.1f s  %s  peers %.2f  bodies %.2f  moving mm p50 %.2f p95 %.2f max %.1f  "
                 "resting mm p95 %.3f max %.2f  (%zu, %zu)\n",
                 time, served ? "served" : "ALONE ", connected / people, simulated / people,
                 moving.p50, moving.p95, moving.most, resting.p95, resting.most, moving_.size(),
                 resting_.size());
  }
  all_moving_.insert(all_moving_.end(), moving_.begin(), moving_.end());
  all_resting_.insert(all_resting_.end(), resting_.begin(), resting_.end());
  moving_.clear();
  resting_.clear();
}

void Square::census() {
  const auto hub = connect(options_);
  const nats::CellOptions cells = options_.cells();
  nats::BodyLedger ledger({.hub = hub,
                           .scene_hash = options_.scene_hash(),
                           .session_key = plaza_key(),
                           .cells = cells});
  // Some were thrown over the rim.
  constexpr double kRim = 20.0;
  const nats::Cell low = nats::cell_at(cells, pbd::Vec3::Constant(-kRim));
  const nats::Cell high = nats::cell_at(cells, pbd::Vec3::Constant(options_.side + kRim));
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      ledger.watch({0, x, y});
      if (ledger.waiting() > nats::BodyLedger::kMaxWaiting / 2) wait_for(ledger);
    }
  }
  wait_for(ledger);
  std::vector<nats::LedgerNews> news;
  ledger.take(news);
  std::map<consensus::SharedId, std::size_t> found;
  for (const nats::LedgerNews& each : news) ++found[each.record.id];
  for (std::size_t i = 0; i < options_.bodies; ++i) {
    const std::size_t count = found[PlazaBody::id(i)];
    report_.bodies_lost += count == 0 ? 1 : 0;
    report_.bodies_twice += count > 1 ? 1 : 0;
  }
}

std::array<double, 7> Square::counts() const {
  const auto total = [this](auto field) {
    std::uint64_t sum = 0;
    for (const auto& hub : hubs_) sum += hub->status().*field;
    return static_cast<double>(sum);
  };
  std::array<double, 7> out{total(&nats::HubStatus::bytes_in), total(&nats::HubStatus::bytes_out),
                            total(&nats::HubStatus::messages_in),
                            total(&nats::HubStatus::messages_out)};
  for (const auto& visitor : people_) {
    out[4] += static_cast<double>(visitor->far().summaries);
    if (visitor->transport() == nullptr) continue;
    const nats::NatsStatus status = visitor->transport()->status();
    out[0] += static_cast<double>(status.direct_bytes_in);
    out[1] += static_cast<double>(status.direct_bytes_out);
    out[5] += static_cast<double>(status.direct_in);
    out[6] += static_cast<double>(status.direct_out);
  }
  out[2] += out[5];
  out[3] += out[6];
  return out;
}

void Square::sample() {
  ++samples_;
  for (const auto& visitor : people_) {
    report_.connected += static_cast<double>(visitor->connected());
    if (visitor->custody() == nullptr) continue;
    report_.simulated += static_cast<double>(visitor->custody()->local().size());
    const nats::NatsStatus status = visitor->transport()->status();
    report_.cells += static_cast<double>(status.cells);
    report_.direct += static_cast<double>(status.direct);
  }
}

void Square::sum_up(const std::array<double, 7>& before) {
  const auto after = counts();
  const double people = static_cast<double>(people_.size());
  const auto per = [&](std::size_t i) {
    return (after[i] - before[i]) / people / options_.seconds;
  };
  report_.session_s = options_.seconds;
  report_.kbit_in = 8e-3 * per(0);
  report_.kbit_out = 8e-3 * per(1);
  report_.messages_in = per(2);
  report_.messages_out = per(3);
  report_.summaries = per(4);
  report_.direct_in = per(5);
  report_.direct_out = per(6);
  const double samples = people * static_cast<double>(std::max<std::size_t>(1, samples_));
  for (double* sum : {&report_.connected, &report_.direct, &report_.simulated, &report_.cells}) {
    *sum /= samples;
  }
  report_.moving_mm = spread_of(all_moving_);
  report_.resting_mm = spread_of(all_resting_);
  for (const auto& visitor : people_) {
    report_.taken += visitor->taken();
    report_.people_told = std::max(report_.people_told, visitor->far().people);
    if (visitor->custody() == nullptr) continue;
    const Custody::Counters& counters = visitor->custody()->counters();
    report_.crossings += counters.crossings;
    report_.written += counters.written;
    report_.refused += counters.refused;
  }
}

SquareReport Square::run() {
  arrive();
  const auto steps = [this](double seconds) {
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(seconds * options_.step_hz));
  };
  const std::int64_t settle = steps(kSettle);
  const std::int64_t all = settle + steps(options_.seconds);
  double cpu = 0.0;
  double watching = 0.0;  // s of CPU outside the visitors
  std::array<double, 7> counted{};
  auto wall = std::chrono::steady_clock::now();
  std::int64_t now = clock_.begin_step();
  for (std::int64_t step = 0; step < all; ++step) {
    const std::int64_t end = now + static_cast<std::int64_t>(1e9 / options_.step_hz);
    if (step == settle) {
      cpu = cpu_seconds();
      watching = 0.0;
      counted = counts();
      wall = std::chrono::steady_clock::now();
      for (auto* values : {&all_moving_, &all_resting_, &moving_, &resting_}) values->clear();
    }
    for (const auto& visitor : people_) visitor->step(now, end);
    const double before = cpu_seconds();
    if (step % steps(kLookEvery) == 0) {
      look();
      if (step >= settle) sample();
    }
    if ((step + 1) % steps(1.0) == 0) {
      tell(static_cast<double>(step + 1 - settle) / options_.step_hz);
    }
    watching += cpu_seconds() - before;
    now = clock_.begin_step();
  }
  report_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count();
  report_.cpu_s = cpu_seconds() - cpu - watching;
  sum_up(counted);
  for (const auto& visitor : people_) visitor->leave(now);
  people_.clear();
  hubs_.clear();
  if (options_.wire == PlazaWire::Nats) census();
  return report_;
}

}  // namespace tandem::demos
