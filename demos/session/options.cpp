// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/options.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "session/option_values.h"
#include "session/published_rules.h"

namespace tandem::demos {

namespace {

/// Kinds of runs that an option applies to.
enum class Where : std::uint8_t { Everywhere, Virtual, Network };

/// An option of the command line, and its effect.
struct DemoOption {
  std::string_view name;
  Where where;
  void (*read)(Argument& in, DemoOptions& o);
};

constexpr double kEndless = 3600.0;  // s, of users' scripts
constexpr std::string_view kChance = "a number from 0 to 0.99";
constexpr std::string_view kPort = "a port from 0 (any) to 65535";
constexpr std::uint64_t kMax64 = std::numeric_limits<std::uint64_t>::max();

template <bool DemoOptions::*Member>
void read_flag(Argument&, DemoOptions& o) {
  o.*Member = true;
}

template <std::string DemoOptions::*Member>
void read_text(Argument& in, DemoOptions& o) {
  o.*Member = in.text();
}

/// Null if there is no such name.
const consensus::NamedNetwork* named_network(std::string_view name) {
  const std::span<const consensus::NamedNetwork> all = consensus::named_networks();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const auto& network) { return network.name == name; });
  return found != all.end() ? &*found : nullptr;
}

std::string network_names() {
  std::string out = "one of";
  for (const consensus::NamedNetwork& network : consensus::named_networks()) {
    out += ' ';
    out += network.name;
  }
  return out;
}

void read_link(Argument& in, DemoOptions& o) {
  constexpr std::array<std::string_view, 6> kItems{"loss",      "duplicate", "reorder",
                                                   "bandwidth", "max-state", "network"};
  in.items(kItems, [&o](std::string_view key, std::string_view value) {
    if (key == "loss") o.loss = number("--link loss", value, 0.0, 0.99, kChance);
    if (key == "duplicate") o.duplicate = number("--link duplicate", value, 0.0, 0.99, kChance);
    if (key == "reorder") o.reorder = number("--link reorder", value, 0.0, 0.99, kChance);
    if (key == "bandwidth") {
      o.bandwidth =
          limit("--link bandwidth", value, 1.0, 1e12, "0 or a number from 1 to 1e12 bit/s");
    }
    if (key == "max-state") {
      o.max_state_bytes = number("--link max-state", value, std::size_t{128}, std::size_t{65536},
                                 "an integer from 128 to 65536 bytes");
    }
    if (key == "network") {
      if (named_network(value) == nullptr) refuse("--link network", value, network_names());
      o.network = value;
    }
  });
}

void read_send(Argument& in, DemoOptions& o) {
  constexpr std::array<std::string_view, 5> kItems{"hz", "compact", "budget", "tolerance", "near"};
  in.items(kItems, [&o](std::string_view key, std::string_view value) {
    if (key == "hz") {
      o.update_hz = number("--send hz", value, 0.1, 1000.0, "a number from 0.1 to 1000");
    }
    if (key == "compact") {
      if (!value.empty()) refuse("--send compact", value, "without a value");
      o.compact = true;
    }
    if (key == "budget") {
      o.budget = limit("--send budget", value, 8.0, 1e6, "0 or a number from 8 to 1e6 kbit/s");
    }
    if (key == "tolerance") {
      o.tolerance = number("--send tolerance", value, 0.0, 10.0, "a number from 0 to 10 m");
    }
    if (key == "near")
      o.interest_radius = limit("--send near", value, 0.1, 1e4, "0 or from 0.1 to 1e4 m");
  });
}

void read_agreement(Argument& in, DemoOptions& o) {
  constexpr std::array<std::string_view, 3> kItems{"share", "budget", "inputs"};
  in.items(kItems, [&o](std::string_view key, std::string_view value) {
    if (key == "share") {
      o.replayed.share = number("--agreement share", value, 1e-3, 1.0, "a number from 0.001 to 1");
    }
    if (key == "budget") {
      o.replayed.budget =
          number("--agreement budget", value, 1.0, 1000.0, "a number from 1 to 1000");
    }
    if (key == "inputs") {
      if (value != "known" && value != "common") {
        refuse("--agreement inputs", value, "known or common");
      }
      o.replayed.inputs =
          value == "common" ? consensus::ReplayInputs::Common : consensus::ReplayInputs::Known;
    }
  });
}

void read_clock(Argument& in, DemoOptions& o) {
  constexpr std::array<std::string_view, 5> kItems{"session", "system", "none", "spread",
                                                   "off-grid"};
  in.items(kItems, [&o](std::string_view key, std::string_view value) {
    if (key == "off-grid") {
      if (!value.empty()) refuse("--clock off-grid", value, "without a value");
      o.off_grid = true;
      return;
    }
    if (key == "spread") {
      o.clock_spread = number("--clock spread", value, 0.0, 1e6, "a number from 0 to 1e6 s");
      return;
    }
    o.timeline = key == "none"     ? Timeline::None
                 : key == "system" ? Timeline::System
                                   : Timeline::Session;
  });
}

/// Coupling of the run and, after a comma, of the comparison run.
void read_coupling(Argument& in, DemoOptions& o) {
  const std::string_view text = in.value();
  const std::vector<std::string_view> items = items_of(text);
  if (items.size() > 2) refuse(in.name(), text, "A, or A,B to show it beside B");
  o.scheme = scheme(in.name(), items[0]);
  o.alone = items.size() == 2 && items[1] == "nothing";
  o.beside.reset();
  if (items.size() == 2 && !o.alone) o.beside = scheme(in.name(), items[1]);
}

/// Iterations of Tandem's pass and, after a comma, of Bullet's solver.
void read_iterations(Argument& in, DemoOptions& o) {
  const std::string_view text = in.value();
  const std::vector<std::string_view> items = items_of(text);
  if (items.size() > 2) refuse("--iterations", text, "N, or N,M with M of Bullet's solver");
  o.solver.position_iterations =
      number("--iterations", items[0], 1, 1000, "an integer from 1 to 1000");
  if (items.size() == 2) {
    o.bullet_iterations =
        number("--iterations of Bullet", items[1], 1, 10000, "an integer from 1 to 10000");
  }
}

constexpr DemoOption kOptions[] = {
    {"--peers", Where::Virtual,
     [](Argument& in, DemoOptions& o) { o.peers = in.number(1, 64, "an integer from 1 to 64"); }},
    {"--profile", Where::Virtual,
     [](Argument& in, DemoOptions& o) { o.profile = in.number(0, 5, "an integer from 0 to 5"); }},
    {"--link", Where::Virtual, read_link},
    {"--send", Where::Everywhere, read_send},
    {"--listen", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       o.listen = in.number(std::uint16_t{0}, std::uint16_t{65535}, kPort);
     }},
    {"--connect", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.connect.push_back(address(in.value())); }},
    {"--peer-id", Where::Network,
     [](Argument& in, DemoOptions& o) {
       o.peer_id = in.number(std::uint64_t{1}, std::uint64_t{1} << 62,
                             "an integer >= 1, unique in the session");
     }},
    {"--wait", Where::Network,
     [](Argument& in, DemoOptions& o) {
       o.wait = in.number(0.0, 86400.0, "a number from 0 to 86400 s");
     }},
    {"--key", Where::Network, read_text<&DemoOptions::key>},
    {"--transport", Where::Network,
     [](Argument& in, DemoOptions& o) {
       const std::string_view text = in.value();
       if (text != "tcp" && text != "udp") refuse("--transport", text, "tcp or udp");
       o.wire = text == "udp" ? Wire::Udp : Wire::Tcp;
     }},
    {"--clock", Where::Everywhere, read_clock},
    {"--seconds", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       o.seconds = in.number(0.1, 86400.0, "a number from 0.1 to 86400");
     }},
    {"--view", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.view = in.port(o.view_address); }},
    {"--seed", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       o.seed = in.number(std::uint64_t{0}, kMax64, "an integer of 64 bits, >= 0");
     }},
    {"--influence", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.influence = in.number(0.0, 0.99, kChance); }},
    {"--coupling", Where::Everywhere, read_coupling},
    {"--rates", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.rates = rates(in.value()); }},
    {"--engines", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.engines = engines(in.value()); }},
    {"--substeps", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       o.solver.substeps = in.number(1, 1000, "an integer from 1 to 1000");
     }},
    {"--iterations", Where::Everywhere, read_iterations},
    {"--ablate", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.ablation = ablation(in.value()); }},
    {"--variant", Where::Everywhere, read_text<&DemoOptions::variant>},
    {"--script", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       constexpr std::string_view kHands = "hands=";
       const std::string what = in.text();
       o.hands.clear();
       o.replay.clear();
       o.no_script = what == "none";
       if (!what.starts_with(kHands)) {
         if (!o.no_script) o.replay = what;
         return;
       }
       for (const std::string_view file : items_of(std::string_view(what).substr(kHands.size()))) {
         if (file.empty()) refuse(in.name(), what, "none, FILE or hands=FILE,..");
         o.hands.emplace_back(file);
       }
     }},
    {"--predictor", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.predictor = predictor(in.value()); }},
    {"--agreement", Where::Everywhere, read_agreement},
    {"--mode", Where::Everywhere, [](Argument& in, DemoOptions& o) { o.mode = mode(in.value()); }},
    {"--json", Where::Everywhere, read_text<&DemoOptions::json>},
    {"--csv", Where::Everywhere, read_text<&DemoOptions::csv>},
    {"--record", Where::Everywhere,
     [](Argument& in, DemoOptions& o) {
       const std::string file = in.text();
       (file.ends_with(".glb") ? o.glb : o.record) = file;
     }},
    {"--trace", Where::Everywhere, read_text<&DemoOptions::trace>},
    {"--reference", Where::Everywhere, read_flag<&DemoOptions::reference>},
    {"--print", Where::Everywhere,
     [](Argument& in, DemoOptions& o) { o.print = print(in.value()); }},
};

[[noreturn]] void refuse_pair(std::string_view option, std::string_view why) {
  throw UsageError(std::string(option) + ' ' + std::string(why));
}

/// Refuses combinations of options without meaning.
void check_together(const DemoOptions& o, std::string_view virtual_only,
                    std::string_view network_only) {
  if (o.over_network() && !virtual_only.empty()) {
    refuse_pair(virtual_only, "has no meaning with --listen or --connect");
  }
  if (!o.over_network() && !network_only.empty()) {
    refuse_pair(network_only, "needs --listen or --connect");
  }
  if (o.over_network() && !o.udp() && o.timeline == Timeline::None) {
    refuse_pair("--clock none", "needs --key or --transport udp over a network");
  }
  if (o.view && (o.beside || o.alone)) refuse_pair("--coupling A,B", "has no meaning with --view");
  for (const auto& [name, file] : {std::pair{"--json", &o.json},
                                   {"--csv", &o.csv},
                                   {"--record", &o.record},
                                   {"--record", &o.glb}}) {
    if (o.endless && !file->empty()) refuse_pair(name, "with --view needs --seconds");
  }
}

void apply(Scheme scheme, consensus::PeerOptions& options) {
  using consensus::Coupling;
  options.two_step_thresholds = scheme == Scheme::TwoStepPaper;
  if (options.two_step_thresholds) options = consensus::with_published_rules(std::move(options));
  switch (scheme) {
    case Scheme::OnePass:
      options.coupling = Coupling::OnePass;
      break;
    case Scheme::TwoStepPaper:
    case Scheme::TwoStep:
      options.coupling = Coupling::TwoStep;
      break;
    case Scheme::None:
      options.coupling = Coupling::None;
      break;
    case Scheme::SingleOwner:
      options.coupling = Coupling::SingleOwner;
      options.predictor = consensus::PredictorKind::Euler;
      break;
  }
}

}  // namespace

consensus::PeerOptions DemoOptions::peer_options(Scheme other) const {
  consensus::PeerOptions result;
  result.update_hz = update_hz;
  if (timeline == Timeline::None) result.timestamps = consensus::TimestampSource::Arrival;
  if (compact) result.sending.format = consensus::StateFormat::Compact;
  result.sending.kbit_per_s = budget;
  result.sending.tolerance = tolerance;
  result.influence.baseline = influence;
  if (influence <= 0.0) result.influence.held_alone = 0.0;  // no agreement
  apply(other, result);
  if (predictor) {
    result.predictor = *predictor;
    result.prediction.extrapolates_orientation = true;
  }
  result.replay = replayed;
  result.mode = mode;
  ablation.apply(result);
  return result;
}

Scheme DemoOptions::scheme_of(std::size_t peer) const {
  return engine(peer) != Engine::Tandem && scheme == Scheme::OnePass ? Scheme::TwoStep : scheme;
}

consensus::LinkOptions DemoOptions::link_options() const {
  consensus::LinkOptions result;
  if (profile > 0) result = consensus::network_profile(profile);
  result.loss = loss;
  result.duplicate = duplicate;
  result.reorder = reorder;
  result.bandwidth = bandwidth;
  result.max_state_bytes = max_state_bytes;
  return result;
}

void DemoOptions::set_links(consensus::VirtualNetwork& links) const {
  const consensus::NamedNetwork* const other = named_network(network);
  const auto count = static_cast<consensus::PeerId>(peers);
  for (consensus::PeerId from = 1; from <= count; ++from) {
    for (consensus::PeerId to = 1; to <= count; ++to) {
      if (from == to) continue;
      consensus::LinkOptions link = link_options();
      if (other != nullptr && from == kOnNetwork) link = other->up;
      if (other != nullptr && to == kOnNetwork) link = other->down;
      links.set_link(from, to, link);
    }
  }
}

DemoOptions parse_options(std::span<const std::string_view> arguments) {
  DemoOptions options;
  std::string_view virtual_only;  // an option without meaning over a real network
  std::string_view network_only;
  bool timed = false;
  std::vector<Option> known;
  for (const DemoOption& option : kOptions) {
    known.push_back({option.name, [&](Argument& in) {
                       option.read(in, options);
                       timed = timed || option.name == "--seconds";
                       if (option.where == Where::Virtual) virtual_only = option.name;
                       if (option.where == Where::Network) network_only = option.name;
                     }});
  }
  read_arguments(arguments, known);
  // The system clock applies to networks alone.
  if (options.timeline == Timeline::System) network_only = "--clock system";
  if (options.clock_spread > 0.0) virtual_only = "--clock spread";
  if (options.off_grid) virtual_only = "--clock off-grid";
  if (options.beside || options.alone) virtual_only = "--coupling A,B";
  // Without a key only on this machine, as over TCP.
  options.insecure = options.wire == Wire::Udp && options.key.empty();
  options.endless = options.view.has_value() && !timed;
  check_together(options, virtual_only, network_only);
  // Users' scripts need a length.
  if (options.endless) options.seconds = kEndless;
  // The listening peer is user A, the connecting one user B.
  if (options.over_network() && options.peer_id == 0) {
    options.peer_id = options.connect.empty() ? 1 : 2;
  }
  return options;
}

void check_results(const DemoOptions& o) {
  if (!o.json.empty() && o.json != "-") require_writable_file("--json", o.json);
  if (!o.record.empty()) require_writable_file("--record", o.record);
  if (!o.glb.empty()) require_writable_file("--record", o.glb);
  if (!o.csv.empty()) require_writable_folder("--csv", o.csv);
  // Peers of one process write a file each, see open_trace().
  if (!o.trace.empty()) require_writable_file("--trace", o.trace + (o.over_network() ? "" : ".1"));
}

}  // namespace tandem::demos
