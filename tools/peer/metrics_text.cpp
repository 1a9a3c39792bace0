// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/metrics_text.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace tandem::demos {

namespace {

constexpr std::array<double, 4> kQuantiles = {0.5, 0.95, 0.99, 1.0};

std::string digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string label(consensus::PeerId peer) { return "peer=\"" + std::to_string(peer) + '"'; }

class Page {
 public:
  void begin(const std::string& name, const char* type, const char* help) {
    name_ = "tandem_" + name;
    text_ += "# HELP " + name_ + ' ' + help + "\n# TYPE " + name_ + ' ' + type + '\n';
  }
  void value(const std::string& labels, double value, const char* suffix = "") {
    text_ += name_ + suffix + (labels.empty() ? "" : '{' + labels + '}') + ' ' + digits(value);
    text_ += '\n';
  }
  void value(const std::string& labels, std::uint64_t value, const char* suffix = "") {
    text_ += name_ + suffix + (labels.empty() ? "" : '{' + labels + '}') + ' ' +
             std::to_string(value) + '\n';
  }
  void single(const std::string& name, const char* type, const char* help, double number) {
    begin(name, type, help);
    value("", number);
  }
  void quantiles(const std::string& labels, const RecentQuantiles& of) {
    const std::string comma = labels.empty() ? "" : ",";
    for (const double q : kQuantiles) {
      value(labels + comma + "quantile=\"" + digits(q) + '"', of.quantile(q));
    }
    value(labels, of.sum(), "_sum");
    value(labels, of.count(), "_count");
  }
  template <class Number>
  void of_remotes(const PeerFigures& figures, const std::string& name, const char* type,
                  const char* help, const Number& number) {
    begin(name, type, help);
    for (const PeerFigures::Remote& remote : figures.remotes) {
      value(label(remote.status.id), number(remote));
    }
  }
  std::string take() { return std::move(text_); }

 private:
  std::string name_;
  std::string text_;
};

using Remote = PeerFigures::Remote;

void links(Page& page, const PeerFigures& f) {
  page.of_remotes(f, "peer_connected", "gauge", "Whether the peer is connected.",
                  [](const Remote& r) { return std::uint64_t{r.status.connected ? 1U : 0U}; });
  page.of_remotes(f, "packets_received_total", "counter", "Packets from the peer.",
                  [](const Remote& r) { return r.status.packets_in; });
  page.of_remotes(f, "packets_sent_total", "counter", "Packets to the peer.",
                  [](const Remote& r) { return r.status.packets_out; });
  page.of_remotes(f, "received_bytes_total", "counter", "Bytes from the peer.",
                  [](const Remote& r) { return r.status.bytes_in; });
  page.of_remotes(f, "sent_bytes_total", "counter", "Bytes to the peer.",
                  [](const Remote& r) { return r.status.bytes_out; });
  page.of_remotes(f, "packets_dropped_total", "counter",
                  "States dropped because a queue was full or the budget was used up.",
                  [](const Remote& r) { return r.status.dropped_queue_full; });
  page.of_remotes(f, "packets_rejected_total", "counter", "Packets of the peer that were refused.",
                  [](const Remote& r) { return r.status.rejected; });
  page.of_remotes(f, "over_budget_total", "counter",
                  "Packets that were not looked at: the peer sends more than a member may.",
                  [](const Remote& r) { return r.over_budget; });
  page.of_remotes(f, "not_allowed_total", "counter",
                  "States and springs of the peer that its role forbids.",
                  [](const Remote& r) { return r.not_allowed; });
  page.of_remotes(f, "late_steps_total", "counter",
                  "Steps that left out the peer's states: much older than the others'.",
                  [](const Remote& r) { return r.late; });
  page.of_remotes(f, "steps_without_target_total", "counter",
                  "Steps without a target, since the peer's states are so old.",
                  [](const Remote& r) { return r.without; });
  page.of_remotes(f, "loss_ratio", "gauge", "Share of states from the peer lost on the way.",
                  [](const Remote& r) { return r.loss; });
  page.begin("round_trip_seconds", "gauge", "To the peer and back.");
  for (const Remote& r : f.remotes) {
    if (r.round_trip >= 0.0) page.value(label(r.status.id), r.round_trip);
  }
  page.begin("peer_divergence_metres", "summary", "Of bodies' instances there and here, of late.");
  for (const Remote& r : f.remotes) {
    if (r.divergence != nullptr) page.quantiles(label(r.status.id), *r.divergence);
  }
}

}  // namespace

std::size_t PeerFigures::connected() const {
  std::size_t count = 0;
  for (const Remote& remote : remotes) count += remote.status.connected ? 1 : 0;
  return count;
}

std::string metrics_text(const PeerFigures& f) {
  Page page;
  page.begin("info", "gauge", "What this peer runs.");
  page.value("scene=\"" + f.scene + '"', std::uint64_t{1});
  page.single("uptime_seconds", "counter", "Since the start.", f.uptime);
  page.single("peers_connected", "gauge", "Other peers that are connected.",
              static_cast<double>(f.connected()));
  page.begin("step_seconds", "summary", "Wall time of a step, of late.");
  page.quantiles("", *f.step);
  page.begin("divergence_metres", "summary", "Of bodies' instances at all peers, of late.");
  page.quantiles("", *f.divergence);
  if (f.clock_error >= 0.0) {
    page.single("clock_error_bound_seconds", "gauge", "Of session time here, against the others'.",
                f.clock_error);
  }
  page.single("skipped_seconds_total", "counter", "Session time that was not simulated.",
              f.skipped);
  page.single("held_seconds", "gauge", "How far session time is behind: nothing moves until then.",
              f.held);
  page.single("faults_total", "counter", "Steps after which the world was broken.",
              static_cast<double>(f.faults));
  page.single("undecodable_total", "counter", "Packets that did not decode.",
              static_cast<double>(f.packets_rejected));
  page.single("bodies_placed_total", "counter", "Bodies that were taken over from an elected peer.",
              static_cast<double>(f.bodies_placed));
  page.begin("strangers_refused_total", "counter", "What came from nobody that is known.");
  for (const auto& [reason, count] : f.refused) {
    page.value("reason=\"" + std::string(reason) + '"', count);
  }
  links(page, f);
  return page.take();
}

std::string status_text(const PeerFigures& f, std::size_t columns) {
  double loss = 0.0;
  double round_trip = -1.0;
  for (const Remote& r : f.remotes) {
    if (!r.status.connected) continue;
    loss = std::max(loss, r.loss);
    round_trip = std::max(round_trip, r.round_trip);
  }
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "%s  %zu of %zu peers  step %.2f/%.2f ms  apart %.2f/%.1f mm  loss %.1f %%  "
                "round trip %s ms",
                f.scene.c_str(), f.connected(), f.remotes.size(), 1e3 * f.step->quantile(0.5),
                1e3 * f.step->quantile(0.99), 1e3 * f.divergence->quantile(0.5),
                1e3 * f.divergence->quantile(0.99), 100.0 * loss,
                round_trip < 0.0 ? "-" : digits(1e3 * round_trip).c_str());
  std::string line = text.data();
  // A wrapped status line could not be erased.
  if (line.size() >= columns) line.resize(columns > 0 ? columns - 1 : 0);
  return line;
}

}  // namespace tandem::demos
