// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/measures.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "measures/link_probe.h"
#include "scenes/random.h"

namespace tandem::demos {

namespace {

constexpr std::size_t kLatencyBins = 250;

void write_box(JsonWriter& json, std::string_view name, const Distribution& d) {
  json.key(name).begin_object();
  json.field("count", d.count).field("mean", d.mean).field("std", d.std);
  json.field("whisker_low", d.whisker_low).field("p25", d.p25).field("p50", d.p50);
  json.field("p75", d.p75).field("whisker_high", d.whisker_high).field("outliers", d.outliers);
  json.field("p95", d.p95).field("p99", d.p99).field("max", d.max);
  json.end_object();
}

/// @param reference  the same series of the same inputs at one peer; null: not run
void write_stretch(JsonWriter& json, std::string_view name, const Distribution& d,
                   const Distribution* reference) {
  json.key(name).begin_object();
  json.field("p50", d.p50).field("p95", d.p95).field("p99", d.p99).field("samples", d.count);
  if (reference == nullptr) {
    json.null_field("over_reference");
  } else {
    json.key("over_reference").begin_object();
    json.field("p50", d.p50 / reference->p50).field("p95", d.p95 / reference->p95);
    json.field("p99", d.p99 / reference->p99).end_object();
  }
  json.end_object();
}

/// @param reference  null: `stretch` is the reference, or there is none
void write_stretch(JsonWriter& json, const Stretch& stretch, const Stretch* reference) {
  json.key("stretch_m").begin_object();
  write_stretch(json, "one", stretch.one_m, reference != nullptr ? &reference->one_m : nullptr);
  write_stretch(json, "several", stretch.several_m,
                reference != nullptr ? &reference->several_m : nullptr);
  json.end_object();
}

template <class Values>
void write_array(JsonWriter& json, std::string_view name, const Values& values) {
  json.key(name).begin_array();
  for (const auto& value : values) json.value(value);
  json.end_array();
}

void write_smoothness(JsonWriter& json, const Smoothness& s) {
  write_box(json, "acceleration_m_s2", s.acceleration);
  json.field("jerk_rms_m_s3", s.jerk_rms);
  json.field("speed_rms_m_s", s.speed_rms);
  json.field("high_pass_rms_m", s.high_pass_rms_m);
  write_box(json, "spectral_arc_length", s.arc_length);
  write_box(json, "correction_m", s.correction_m);
  json.field("pops_per_minute", s.pops_per_minute);
  write_box(json, "free_speed_m_s", s.free_speed);
}

}  // namespace

std::vector<std::uint64_t> histogram(const std::vector<double>& values, double low, double width,
                                     std::size_t bins) {
  std::vector<std::uint64_t> counts(bins, 0);
  for (const double value : values) {
    const double at = std::clamp((value - low) / width, 0.0, static_cast<double>(bins - 1));
    ++counts[static_cast<std::size_t>(at)];
  }
  return counts;
}

Measures measure(const RunResult& run, const Metrics& metrics, const DemoOptions& options,
                 const RunResult* reference) {
  Measures m;
  m.smooth = smoothness(run.peers);
  std::vector<double> ages;
  double mean_age = 0.0;
  for (const PeerRecord& peer : run.peers) {
    for (const PredictionSample& p : peer.predictions) ages.push_back(1e3 * p.age);
  }
  if (!ages.empty()) mean_age = 1e-3 * metrics.latency_ms.mean;
  // The effect of an update on a step shows at its end.
  double step = 0.0;
  for (const PeerRecord& peer : run.peers) {
    if (peer.step_hz > 0.0) step = std::max(step, 1.0 / peer.step_hz);
  }
  m.latency_histogram = histogram(ages, 0.0, 1.0, kLatencyBins);
  if (!options.over_network()) {
    constexpr double kProbe = 10.0;  // s
    std::vector<double> link = link_latencies(options.link_options(), options.update_hz, kProbe,
                                              derived_seed(options.seed, 5001));
    m.link_histogram = histogram(link, 0.0, 1.0, kLatencyBins);
    m.link_ms = distribution(link);
  }
  m.hits = after_blows(run.peers, metrics.samples, mean_age + step);
  std::vector<double> contacts = contact_disagreement(run.peers);
  if (!contacts.empty()) m.contact_disagreement_end = contacts.back();
  m.contact_disagreement = distribution(contacts);
  m.agree_s = time_to_agree(run.peers, metrics.samples, Measures::kAgreed);
  m.limit_of_all_m = limit_of_all(run.peers, mean_age + step);
  m.held = held_by_one(run.peers);
  m.stretch = stretch(run.peers);
  if (reference != nullptr && !reference->peers.empty()) {
    m.reference = smoothness(reference->peers);
    m.reference_outcome = reference->peers.front().outcome;
    m.reference_stretch = stretch(reference->peers);
    m.residual_m = high_pass_residual(run.peers, reference->peers.front());
  }
  return m;
}

void write_classes(JsonWriter& json, const Metrics& metrics) {
  write_box(json, "divergence_box_m", metrics.divergence_m);
  write_box(json, "divergence_box_deg", metrics.divergence_deg);
  write_box(json, "divergence_calm_m", metrics.calm_m);
  write_box(json, "divergence_shared_m", metrics.shared_m);
  write_box(json, "divergence_shared_moving_m", metrics.shared_moving_m);
  json.field("jumps", metrics.jumps);
  json.key("classes").begin_object();
  for (std::size_t c = 0; c < kObjectClasses; ++c) {
    json.key(to_string(static_cast<ObjectClass>(c))).begin_object();
    write_box(json, "divergence_m", metrics.object_m[c]);
    json.end_object();
  }
  json.end_object();
}

void write_measures(JsonWriter& json, const Measures& m) {
  write_box(json, "link_ms", m.link_ms);
  write_array(json, "link_histogram", m.link_histogram);
  write_array(json, "effective_latency_histogram", m.latency_histogram);
  json.key("smoothness").begin_object();
  write_smoothness(json, m.smooth);
  json.end_object();
  write_box(json, "contact_disagreement", m.contact_disagreement);
  json.field("contact_disagreement_end", m.contact_disagreement_end);
  json.field("time_to_agree_s", m.agree_s);
  write_box(json, "held_limit_m", m.held.limit_m);
  write_box(json, "limit_of_all_m", m.limit_of_all_m);
  write_box(json, "held_by_one_m", m.held.apart_m);
  write_stretch(json, m.stretch, m.reference ? &m.reference_stretch : nullptr);
  json.key("blows").begin_object();
  json.field("count", m.hits.blows);
  write_box(json, "before_m", m.hits.before_m);
  write_box(json, "after_m", m.hits.after_m);
  json.end_object();
  if (!m.reference) {
    json.null_field("reference");
    return;
  }
  json.key("reference").begin_object();
  write_smoothness(json, *m.reference);
  write_box(json, "high_pass_residual_m", m.residual_m);
  write_stretch(json, m.reference_stretch, nullptr);
  json.key("outcome").begin_object();
  for (const auto& [name, value] : m.reference_outcome) json.field(name, value);
  json.end_object();
  json.end_object();
}

}  // namespace tandem::demos
