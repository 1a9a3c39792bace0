// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/report.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "measures/json.h"

namespace tandem::demos {

namespace {

/// ns, of the earliest sample; 0 if there is none.
consensus::SessionTime first_time(const std::vector<PeerRecord>& peers) {
  consensus::SessionTime first = INT64_MAX;
  for (const PeerRecord& peer : peers) {
    for (const Track& track : peer.tracks) {
      if (!track.samples().empty()) first = std::min(first, track.samples().front().time);
    }
  }
  return first == INT64_MAX ? 0 : first;
}

/// ns, session time.
consensus::SessionTime table_start(const Report& report) {
  consensus::SessionTime start = INT64_MAX;
  for (const DivergenceSample& s : report.metrics.samples) start = std::min(start, s.time);
  // A single peer has no exchange.
  return start == INT64_MAX ? first_time(report.run.peers) : start;
}

#ifdef __MINGW_PRINTF_FORMAT  // "printf" means another C library's formats on MinGW
__attribute__((format(__MINGW_PRINTF_FORMAT, 1, 2)))
#else
__attribute__((format(printf, 1, 2)))
#endif
std::string
format(const char* pattern, ...) {
  std::array<char, 256> text{};
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

std::string row(const char* name, const Distribution& d, double scale) {
  if (d.count == 0) return format("  %-26s %9s\n", name, "none");
  return format("  %-26s %9.3f %9.3f %9.3f %9.3f %9.3f %9zu\n", name, scale * d.p50, scale * d.p75,
                scale * d.p95, scale * d.p99, scale * d.max, d.count);
}

/// Percentiles, column by column; the sample count is that of `d`.
std::string ratio_row(const char* name, const Distribution& d, const Distribution& reference) {
  if (d.count == 0 || reference.count == 0) return format("  %-26s %9s\n", name, "none");
  return format("  %-26s %9.3f %9.3f %9.3f %9.3f %9.3f %9zu\n", name, d.p50 / reference.p50,
                d.p75 / reference.p75, d.p95 / reference.p95, d.p99 / reference.p99,
                d.max / reference.max, d.count);
}

void percentiles(JsonWriter& json, std::string_view name, const Distribution& d) {
  json.key(name).begin_object();
  json.field("p50", d.p50).field("p75", d.p75).field("p95", d.p95).field("p99", d.p99);
  json.field("max", d.max).field("mean", d.mean).field("count", d.count);
  json.end_object();
}

const char* class_name(MotionClass motion) {
  switch (motion) {
    case MotionClass::Contested:
      return "contested";
    case MotionClass::Moving:
      return "moving";
    case MotionClass::Resting:
      break;
  }
  return "resting";
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path);
}

void describe_run(JsonWriter& json, const Report& r) {
  const DemoOptions& o = r.options;
  json.field("scenario", r.scenario);
  if (o.variant.empty()) {
    json.null_field("variant");
  } else {
    json.field("variant", o.variant);
  }
  json.field("solver", to_string(o.scheme));
  json.field("predictor", to_string(o.predictor_kind()));
  if (o.over_network()) {
    json.null_field("profile");
  } else {
    json.field("profile", o.profile);
  }
  if (!o.network.empty()) json.field("network", o.network);
  json.field("transport", o.over_network() ? (o.udp() ? "udp" : "tcp") : "virtual");
  json.field("peers", r.run.peers.size()).field("seconds", r.run.seconds).field("seed", o.seed);
  json.field("step_hz", r.run.peers.empty() ? Distribution::kNone : r.run.peers.front().step_hz);
  json.key("step_hz_of_peers").begin_array();
  for (const PeerRecord& peer : r.run.peers) {
    json.value(peer.local ? peer.step_hz : Distribution::kNone);
  }
  json.end_array();
  json.key("engines").begin_array();
  for (std::size_t i = 0; i < r.run.peers.size(); ++i) {
    if (r.run.peers[i].local) json.value(to_string(o.engine(r.run.peers[i].id - 1)));
  }
  json.end_array();
  json.field("update_hz", o.update_hz).field("influence", o.influence);
  json.field("loss", o.over_network() ? Distribution::kNone : o.loss);
  json.field("tables_start_ns", table_start(r));
  json.field("clock_error_bound_s",
             r.run.clock_error < 0.0 ? Distribution::kNone : r.run.clock_error);
  json.field("stable", r.stable());
  if (r.stable()) {
    json.null_field("fault");
  } else {
    json.field("fault", r.fault);
  }
}

}  // namespace

Report make_report(std::string scenario, const DemoOptions& options, RunResult run,
                   std::vector<std::string> body_names, const RunResult* reference) {
  Report report;
  report.scenario = std::move(scenario);
  report.options = options;
  EvaluationOptions evaluation;
  // A peer that was silent for this long was away.
  if (options.over_network()) {
    evaluation.max_gap = static_cast<consensus::SessionTime>(0.2e9 + 2e9 / options.update_hz);
  }
  report.metrics = evaluate(run.peers, evaluation);
  report.measures = measure(run, report.metrics, options, reference);
  for (const PeerRecord& peer : run.peers) {
    if (report.fault.empty()) report.fault = peer.fault;
  }
  report.run = std::move(run);
  report.body_names = std::move(body_names);
  return report;
}

std::string report_table(const Report& r) {
  const DemoOptions& o = r.options;
  const Metrics& m = r.metrics;
  std::string out =
      format("%s: %zu peers, %s, %.1f s, seed %llu, %s, %s, influence %g, %g updates/s\n",
             r.scenario.c_str(), r.run.peers.size(),
             o.over_network() ? (o.udp() ? "UDP" : "TCP") : format("profile %d", o.profile).c_str(),
             r.run.seconds, static_cast<unsigned long long>(o.seed),
             std::string(to_string(o.scheme)).c_str(),
             std::string(to_string(o.predictor_kind())).c_str(), o.influence, o.update_hz);
  out += format("  %-26s %9s %9s %9s %9s %9s %9s\n", "", "p50", "p75", "p95", "p99", "max", "n");
  out += row("divergence, mm", m.divergence_m, 1e3);
  out += row("  contested, mm", m.contested_m, 1e3);
  out += row("  moving, mm", m.moving_m, 1e3);
  out += row("  resting, mm", m.resting_m, 1e3);
  out += row("divergence, degrees", m.divergence_deg, 1.0);
  out += row("prediction error, mm", m.prediction_error_m, 1e3);
  const Measures& measures = r.measures;
  out += row("stretch, held by one, mm", measures.stretch.one_m, 1e3);
  if (measures.reference) {
    out += ratio_row("  over reference", measures.stretch.one_m, measures.reference_stretch.one_m);
  }
  out += row("  held by several, mm", measures.stretch.several_m, 1e3);
  if (measures.reference) {
    out += ratio_row("  over reference", measures.stretch.several_m,
                     measures.reference_stretch.several_m);
  }
  out += row("penetration, mm", m.penetration_m, 1e3);
  out += row("step, ms", m.step_ms, 1.0);
  out += format("  effective latency  mean %.1f ms, std %.1f ms, p99 %.1f ms\n", m.latency_ms.mean,
                m.latency_ms.std, m.latency_ms.p99);
  out += format("  overhead           parse %.2f us, process %.2f us, aggregate %.2f us\n",
                m.parse_us, m.process_us, m.aggregate_us);
  out += format("  each peer sends    %.1f kB/s\n", 1e-3 * m.bytes_per_second);
  out += format("  agreement's energy displacement %.3g J, velocity %.3g J, potential %.3g J\n",
                m.energy.displacement, m.energy.velocity_agreement, m.energy.potential);
  for (const PeerRecord& peer : r.run.peers) {
    if (peer.outcome.empty()) continue;
    out += format("  outcome at peer %llu ", static_cast<unsigned long long>(peer.id));
    for (const auto& [name, value] : peer.outcome) out += format(" %s %.4g,", name.c_str(), value);
    out.back() = '\n';
  }
  out += format("  %.1f times real time, hash %016llx\n", r.run.seconds / r.run.wall_s,
                static_cast<unsigned long long>(m.hash));
  out += r.stable() ? "  stable\n" : "  NOT STABLE: " + r.fault + "\n";
  return out;
}

std::string report_json(const Report& r) {
  const Metrics& m = r.metrics;
  JsonWriter json;
  json.begin_object();
  describe_run(json, r);
  percentiles(json, "divergence_m", m.divergence_m);
  percentiles(json, "divergence_contested_m", m.contested_m);
  percentiles(json, "divergence_moving_m", m.moving_m);
  percentiles(json, "divergence_resting_m", m.resting_m);
  percentiles(json, "divergence_deg", m.divergence_deg);
  percentiles(json, "prediction_error_m", m.prediction_error_m);
  json.key("effective_latency_ms").begin_object();
  json.field("mean", m.latency_ms.mean).field("std", m.latency_ms.std);
  json.field("p99", m.latency_ms.p99).end_object();
  json.key("overhead_us_per_object").begin_object();
  json.field("parse", m.parse_us).field("process", m.process_us);
  json.field("aggregate", m.aggregate_us).field("targets", m.targets_us).end_object();
  json.field("bytes_per_second", m.bytes_per_second);
  std::uint64_t placed = 0;
  for (const PeerRecord& peer : r.run.peers) placed += peer.bodies_placed;
  json.field("bodies_placed", placed);
  json.key("step_ms").begin_object();
  json.field("mean", m.step_ms.mean).field("p50", m.step_ms.p50).field("p99", m.step_ms.p99);
  json.end_object();
  json.field("step_cpu_us", m.step_cpu_us).field("peak_speed_m_s", m.peak_speed);
  json.field("realtime_factor", r.run.seconds / r.run.wall_s);
  json.key("penetration_m").begin_object();
  json.field("p99", m.penetration_m.p99).field("max", m.penetration_m.max).end_object();
  json.key("energy_J").begin_object();
  json.field("displacement", m.energy.displacement);
  json.field("velocity_agreement", m.energy.velocity_agreement);
  json.field("potential", m.energy.potential).end_object();
  json.key("outcome").begin_object();
  for (const PeerRecord& peer : r.run.peers) {
    if (!peer.local) continue;
    json.key("peer_" + std::to_string(peer.id)).begin_object();
    for (const auto& [name, value] : peer.outcome) json.field(name, value);
    json.end_object();
  }
  json.end_object();
  json.field("cpu_s", r.run.cpu_s > 0.0 ? r.run.cpu_s : Distribution::kNone);
  write_classes(json, m);
  write_measures(json, r.measures);
  json.field("hash", format("%016llx", static_cast<unsigned long long>(m.hash)));
  json.end_object();
  return json.text();
}

void write_csv(const Report& report, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot make " + folder + ": " + error.message());
  const consensus::SessionTime start = table_start(report);

  std::string samples = "time_s,body,class,divergence_m,divergence_deg\n";
  std::vector<std::vector<double>> of_body(report.body_names.size());
  for (const DivergenceSample& s : report.metrics.samples) {
    samples += format("%.6f,%s,%s,%.9g,%.9g\n", static_cast<double>(s.time - start) * 1e-9,
                      report.body_names[s.body].c_str(), class_name(s.motion), s.distance,
                      s.angle * 180.0 / std::numbers::pi);
    of_body[s.body].push_back(s.distance);
  }
  write_file(folder + "/divergence.csv", samples);

  std::string tracks = "time_s,peer,body,x,y,z,qw,qx,qy,qz,vx,vy,vz,users\n";
  for (const PeerRecord& peer : report.run.peers) {
    for (std::size_t i = 0; i < peer.tracks.size(); ++i) {
      for (const TrackSample& s : peer.tracks[i].samples()) {
        tracks += format("%.6f,%llu,%s,%.9f,%.9f,%.9f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%d\n",
                         static_cast<double>(s.time - start) * 1e-9,
                         static_cast<unsigned long long>(peer.id), report.body_names[i].c_str(),
                         s.position.x(), s.position.y(), s.position.z(), s.orientation.w(),
                         s.orientation.x(), s.orientation.y(), s.orientation.z(), s.velocity.x(),
                         s.velocity.y(), s.velocity.z(), s.users);
      }
    }
  }
  write_file(folder + "/tracks.csv", tracks);

  std::string series = "time_s,peer,name,value\n";
  for (const PeerRecord& peer : report.run.peers) {
    for (const Series& s : peer.series) {
      for (std::size_t i = 0; i < s.times.size(); ++i) {
        series += format("%.6f,%llu,%s,%.9g\n", s.times[i],
                         static_cast<unsigned long long>(peer.id), s.name.c_str(), s.values[i]);
      }
    }
  }
  write_file(folder + "/series.csv", series);

  std::string bodies = "body,samples,mean_m,p50_m,p95_m,p99_m,max_m\n";
  for (std::size_t i = 0; i < of_body.size(); ++i) {
    const Distribution d = distribution(of_body[i]);
    bodies += format("%s,%zu,%.9g,%.9g,%.9g,%.9g,%.9g\n", report.body_names[i].c_str(), d.count,
                     d.mean, d.p50, d.p95, d.p99, d.max);
  }
  write_file(folder + "/bodies.csv", bodies);
}

void write_inputs(const Report& report, const std::string& path) {
  std::string text;
  for (const PeerRecord& peer : report.run.peers) text += inputs_to_text(peer.inputs);
  write_file(path, text);
}

std::FILE* words_go_to(const DemoOptions& options) { return options.json == "-" ? stderr : stdout; }

int publish(const Report& report, const std::string& words) {
  const DemoOptions& o = report.options;
  if (!o.quiet()) std::fputs(words.c_str(), words_go_to(o));
  if (o.json == "-") {
    std::fputs(report_json(report).c_str(), stdout);
  } else if (!o.json.empty()) {
    write_file(o.json, report_json(report));
  }
  if (!o.csv.empty()) write_csv(report, o.csv);
  if (!o.record.empty()) write_inputs(report, o.record);
  if (!report.stable() && o.quiet()) std::fprintf(stderr, "not stable: %s\n", report.fault.c_str());
  return report.stable() ? 0 : 1;
}

}  // namespace tandem::demos
