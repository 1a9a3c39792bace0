// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/network_watch.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <system_error>

#include "tandem/net/clock.h"

namespace tandem::demos {

namespace {

constexpr std::chrono::seconds kTroubleEvery{10};  // between reports caused by strangers
constexpr std::int64_t kStepTold = 100'000'000;    // ns

}  // namespace

void NetworkWatch::look(const std::vector<consensus::PeerStatus>& peers) {
  const SteadyTime now = std::chrono::steady_clock::now();
  std::erase_if(company_, [&peers](const auto& entry) {
    return !std::ranges::binary_search(peers, entry.first, {}, &consensus::PeerStatus::id);
  });
  for (const consensus::PeerStatus& status : peers) look_at(status, now);
  tell_trouble(now);
  tell_refused(now);
  look_at_group();
  meetings_.look();
  const std::int64_t stepped = network_.clock_stepped();
  if (std::abs(stepped - told_stepped_) <= kStepTold) return;
  told_stepped_ = stepped;
  log_.line(Level::Warn, "system_clock_set", {{"seconds", net::seconds(stepped)}});
}

void NetworkWatch::look_at(const consensus::PeerStatus& status, SteadyTime now) {
  Company& known = company_[status.id];
  if (status.connected != known.connected) {
    known.connected = status.connected;
    if (status.connected) {
      log_.line(Level::Info, "peer_connected", {{"peer", status.id}});
    } else {
      log_.line(Level::Warn, "peer_lost", {{"peer", status.id}, {"reason", status.reason}});
      divergence_.forget(status.id);
    }
  }
  if (status.rejected > known.rejected) {
    log_.line(Level::Warn, "packets_rejected",
              {{"peer", status.id}, {"count", status.rejected - known.rejected}});
    known.rejected = status.rejected;
  }
  if (status.over_budget > known.over_budget && now >= known.next_told) {
    known.next_told = now + kTroubleEvery;
    log_.line(Level::Warn, "over_budget",
              {{"peer", status.id}, {"count", status.over_budget - known.over_budget}});
    known.over_budget = status.over_budget;
  }
}

void NetworkWatch::tell_trouble(SteadyTime now) {
  const std::string trouble = network_.trouble();
  if (trouble == trouble_ || now < next_trouble_) return;
  next_trouble_ = now + kTroubleEvery;
  trouble_ = trouble;
  if (!trouble.empty()) log_.line(Level::Warn, "network", {{"what", trouble.substr(2)}});
}

/// Reports refusals of strangers since the last report.
void NetworkWatch::tell_refused(SteadyTime now) {
  if (now < next_refused_) return;
  for (const auto& [reason, count] : network_.refused()) {
    std::uint64_t& told = told_refused_[reason];
    if (count == told) continue;
    log_.line(Level::Warn, "strangers_refused", {{"reason", reason}, {"count", count - told}});
    told = count;
    next_refused_ = now + kTroubleEvery;
  }
}

/// The organiser's latest change, from its file or from another member.
void NetworkWatch::look_at_group() {
  if (!config_.group_file.empty()) {
    std::error_code ignored;
    const auto written = std::filesystem::last_write_time(config_.group_file, ignored);
    if (!ignored && written != group_written_) {
      try {
        network_.change_group(read_secret_hex_file(config_.group_file));
        group_written_ = written;
        group_fault_.clear();
      } catch (const std::invalid_argument& error) {
        // It is read again, as access to it may change without its time.
        if (group_fault_ != error.what()) {
          log_.line(Level::Warn, "group_file", {{"what", error.what()}});
        }
        group_fault_ = error.what();
      }
    }
  }
  if (network_.group() == group_) return;
  group_ = network_.group();
  log_.line(Level::Info, "group_changed", {{"number", group_}});
}

}  // namespace tandem::demos
