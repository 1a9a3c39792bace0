// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/options.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "common/option_values.h"

namespace tandem::demos {

namespace {

/// Goes through the arguments; knows which of them were named.
class Reader {
 public:
  explicit Reader(std::span<const std::string_view> arguments) : arguments_(arguments) {}

  /// The next option's name, empty at the end.
  std::string_view next() {
    if (at_ == arguments_.size()) return {};
    std::string_view argument = arguments_[at_++];
    inline_value_.reset();
    if (!argument.starts_with("--")) refuse("argument", argument, "options begin with --");
    if (const std::size_t equals = argument.find('='); equals != std::string_view::npos) {
      inline_value_ = argument.substr(equals + 1);
      argument = argument.substr(0, equals);
    }
    return argument;
  }
  std::string_view value(std::string_view option) {
    if (inline_value_) return *std::exchange(inline_value_, std::nullopt);
    if (at_ == arguments_.size()) refuse(option, "", "needs a value");
    return arguments_[at_++];
  }
  /// A value that may be left out: what follows is one where it is no option.
  std::string_view value_or(std::string_view option, std::string_view fallback) {
    const bool follows =
        at_ < arguments_.size() && !arguments_[at_].empty() && !arguments_[at_].starts_with("--");
    return inline_value_ || follows ? value(option) : fallback;
  }
  /// After an option without a value.
  void finish(std::string_view option) const {
    if (inline_value_) refuse(option, *inline_value_, "takes no value");
  }

 private:
  std::span<const std::string_view> arguments_;
  std::size_t at_ = 0;
  std::optional<std::string_view> inline_value_;
};

/// Where an option has a meaning.
enum class Where : std::uint8_t { Everywhere, Virtual, Network };

/// An option of the command line, and what it does.
struct Option {
  std::string_view name;
  Where where;
  void (*read)(std::string_view name, Reader& in, DemoOptions& o);
};

constexpr double kEndless = 3600.0;  // s, of users' scripts
constexpr std::string_view kSeconds = "s, a number from 0 to 10";
constexpr std::string_view kChance = "a number from 0 to 0.99";
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kMax64 = std::numeric_limits<std::uint64_t>::max();

template <bool DemoOptions::*Member>
void read_flag(std::string_view name, Reader& in, DemoOptions& o) {
  in.finish(name);
  o.*Member = true;
}

template <std::string DemoOptions::*Member>
void read_text(std::string_view name, Reader& in, DemoOptions& o) {
  const std::string_view value = in.value(name);
  if (value.empty()) refuse(name, value, "must not be empty");
  o.*Member = std::string(value);
}

template <double DemoOptions::*Member>
void read_chance(std::string_view name, Reader& in, DemoOptions& o) {
  o.*Member = number(name, in.value(name), 0.0, 0.99, kChance);
}

template <double DemoOptions::*Member>
void read_seconds(std::string_view name, Reader& in, DemoOptions& o) {
  o.*Member = number(name, in.value(name), 0.0, 10.0, kSeconds);
}

void read_scheme(std::string_view name, Reader& in, DemoOptions& o) {
  o.scheme = scheme(name, in.value(name));
}

constexpr Option kOptions[] = {
    {"--peers", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.peers = number(name, in.value(name), 1, 64, "an integer from 1 to 64");
     }},
    {"--profile", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.profile = number(name, in.value(name), 0, 5, "an integer from 0 to 5");
     }},
    {"--loss", Where::Virtual, read_chance<&DemoOptions::loss>},
    {"--duplicate", Where::Virtual, read_chance<&DemoOptions::duplicate>},
    {"--reorder", Where::Virtual, read_chance<&DemoOptions::reorder>},
    {"--bandwidth", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.bandwidth = limit(name, in.value(name), 1.0, 1e12, "bit/s, 0 or a number from 1 to 1e12");
     }},
    {"--max-state", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.max_state_bytes = number(name, in.value(name), std::size_t{128}, std::size_t{65536},
                                  "bytes, an integer from 128 to 65536");
     }},
    {"--compact", Where::Everywhere, read_flag<&DemoOptions::compact>},
    {"--budget", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.budget = limit(name, in.value(name), 8.0, 1e6, "kbit/s, 0 or a number from 8 to 1e6");
     }},
    {"--tolerance", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.tolerance = number(name, in.value(name), 0.0, 10.0, "m, a number from 0 to 10");
     }},
    {"--listen", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.listen = number(name, in.value(name), std::uint16_t{0}, std::uint16_t{65535},
                         "a port from 0 (any) to 65535");
     }},
    {"--connect", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.connect.push_back(address(in.value(name)));
     }},
    {"--peer-id", Where::Network,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.peer_id = number(name, in.value(name), std::uint64_t{1}, std::uint64_t{1} << 62,
                          "an integer >= 1, unique in the session");
     }},
    {"--wait", Where::Network,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.wait = number(name, in.value(name), 0.0, 86400.0, "a number from 0 to 86400");
     }},
    {"--key", Where::Network, read_text<&DemoOptions::key>},
    {"--insecure", Where::Network, read_flag<&DemoOptions::insecure>},
    {"--transport", Where::Network,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       const std::string_view text = in.value(name);
       if (text != "tcp" && text != "udp") refuse(name, text, "tcp or udp");
       o.wire = text == "udp" ? Wire::Udp : Wire::Tcp;
     }},
    {"--clock", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       const std::string_view text = in.value(name);
       if (text != "session" && text != "system" && text != "none") {
         refuse(name, text, "session, system or none");
       }
       o.timeline = text == "none"     ? Timeline::None
                    : text == "system" ? Timeline::System
                                       : Timeline::Session;
     }},
    {"--clock-spread", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.clock_spread = number(name, in.value(name), 0.0, 1e6, "s, a number from 0 to 1e6");
     }},
    {"--seconds", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.seconds = number(name, in.value(name), 0.1, 86400.0, "a number from 0.1 to 86400");
     }},
    {"--view", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.view = number(name, in.value_or(name, "0"), std::uint16_t{0}, std::uint16_t{65535},
                       "a port from 0 (any) to 65535");
     }},
    {"--view-address", Where::Everywhere, read_text<&DemoOptions::view_address>},
    {"--no-script", Where::Everywhere, read_flag<&DemoOptions::no_script>},
    {"--seed", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.seed =
           number(name, in.value(name), std::uint64_t{0}, kMax64, "an integer of 64 bits, >= 0");
     }},
    {"--influence", Where::Everywhere, read_chance<&DemoOptions::influence>},
    {"--coupling", Where::Everywhere, read_scheme},
    {"--solver", Where::Everywhere, read_scheme},  // the older name
    {"--pd-frequency", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.pd_frequency = number(name, in.value(name), 0.01, 100.0, "a number from 0.01 to 100");
     }},
    {"--update-hz", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.update_hz = number(name, in.value(name), 0.1, 1000.0, "a number from 0.1 to 1000");
     }},
    {"--uneven", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       in.finish(name);
       o.rates = {60.0, 72.0};
     }},
    {"--phases", Where::Virtual,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       const std::string_view text = in.value(name);
       if (text != "session" && text != "random") refuse(name, text, "session or random");
       o.random_phases = text == "random";
     }},
    {"--rates", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) { o.rates = rates(in.value(name)); }},
    {"--engines", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.engines = engines(in.value(name));
     }},
    {"--bullet-iterations", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.bullet_iterations = number(name, in.value(name), 1, 10000, "an integer from 1 to 10000");
     }},
    {"--substeps", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.solver.substeps = number(name, in.value(name), 1, 1000, "an integer from 1 to 1000");
     }},
    {"--iterations", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.solver.position_iterations =
           number(name, in.value(name), 1, 1000, "an integer from 1 to 1000");
     }},
    {"--ablate", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.ablation = ablation(in.value(name));
     }},
    {"--variant", Where::Everywhere, read_text<&DemoOptions::variant>},
    {"--replay", Where::Everywhere, read_text<&DemoOptions::replay>},
    {"--predictor", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.predictor = predictor(in.value(name));
     }},
    {"--closing-share", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.replayed.share = number(name, in.value(name), 1e-3, 1.0, "a number from 0.001 to 1");
     }},
    {"--inputs", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.replayed.inputs = inputs(in.value(name));
     }},
    {"--replay-budget", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.replayed.budget = number(name, in.value(name), 1.0, 1000.0, "a number from 1 to 1000");
     }},
    {"--replay-substeps", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       o.replayed.substeps = number(name, in.value(name), 0, 1000, "an integer from 0 to 1000");
     }},
    {"--mode", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) { o.mode = mode(in.value(name)); }},
    {"--extrapolation", Where::Everywhere, read_seconds<&DemoOptions::extrapolation>},
    {"--spring-extrapolation", Where::Everywhere, read_seconds<&DemoOptions::spring_extrapolation>},
    {"--json", Where::Everywhere, read_text<&DemoOptions::json>},
    {"--csv", Where::Everywhere, read_text<&DemoOptions::csv>},
    {"--record", Where::Everywhere,
     [](std::string_view name, Reader& in, DemoOptions& o) {
       const std::string_view file = in.value(name);
       (file.ends_with(".glb") ? o.glb : o.record) = file;
     }},
    {"--trace", Where::Everywhere, read_text<&DemoOptions::trace>},
    {"--reference", Where::Everywhere, read_flag<&DemoOptions::reference>},
    {"--quiet", Where::Everywhere, read_flag<&DemoOptions::quiet>},
    {"--help", Where::Everywhere, read_flag<&DemoOptions::help>},
};

/// What a scheme is made of.
void apply(Scheme scheme, consensus::PeerOptions& options) {
  using consensus::Coupling;
  const bool as_published = scheme == Scheme::OnePassPlain || scheme == Scheme::TwoStepPaper ||
                            scheme == Scheme::TwoStepPlain || scheme == Scheme::Pd;
  if (as_published) options = consensus::with_published_rules(std::move(options));
  options.two_step_thresholds = scheme == Scheme::TwoStepPaper;
  switch (scheme) {
    case Scheme::OnePass:
    case Scheme::OnePassPlain:
      options.coupling = Coupling::OnePass;
      break;
    case Scheme::TwoStepPaper:
    case Scheme::TwoStepPlain:
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
    case Scheme::Pd:
      // Its force has a limit of its own.
      options.robust.max_correction = options.robust.max_turn = kUnlimited;
      options.robust.max_velocity_correction = options.robust.max_spin_correction = kUnlimited;
      // A spring is not stable against a turning body that is said to stand still.
      options.prediction.extrapolates_orientation = true;
      break;
  }
}

}  // namespace

consensus::PeerOptions DemoOptions::peer_options(Scheme other) const {
  consensus::PeerOptions result;
  result.update_hz = update_hz;
  if (timeline == Timeline::None) result.dating = consensus::Dating::Receipt;
  if (compact) result.sending.format = consensus::StateFormat::Compact;
  result.sending.kbit_per_s = budget;
  result.sending.tolerance = tolerance;
  result.influence.baseline = influence;
  if (influence <= 0.0) result.influence.held_alone = 0.0;  // no agreement at all
  apply(other, result);
  if (predictor) {
    result.predictor = *predictor;
    result.prediction.extrapolates_orientation = true;
  }
  result.replay = replayed;
  result.mode = mode;
  result.prediction.max_extrapolation = extrapolation;
  result.max_anchor_extrapolation = spring_extrapolation;
  ablation.apply(result);
  return result;
}

pbd::SolverOptions DemoOptions::solver_options() const {
  pbd::SolverOptions result = solver;
  ablation.apply(result);
  return result;
}

Scheme DemoOptions::scheme_of(std::size_t peer) const {
  if (engine(peer) == Engine::Tandem) return scheme;
  if (scheme == Scheme::OnePass) return Scheme::TwoStep;
  if (scheme == Scheme::OnePassPlain) return Scheme::TwoStepPlain;
  return scheme == Scheme::Pd ? Scheme::TwoStepPaper : scheme;
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

DemoOptions parse_options(std::span<const std::string_view> arguments) {
  DemoOptions options;
  Reader in(arguments);
  std::string_view virtual_only;  // an option that has no meaning over a real network
  std::string_view network_only;
  bool timed = false;
  for (std::string_view name = in.next(); !name.empty(); name = in.next()) {
    const auto* const option = std::find_if(std::begin(kOptions), std::end(kOptions),
                                            [name](const Option& o) { return o.name == name; });
    if (option == std::end(kOptions)) {
      refuse("option", name, "must be one of those that --help lists");
    }
    option->read(name, in, options);
    timed = timed || name == "--seconds";
    if (option->where == Where::Virtual) virtual_only = name;
    const bool needs_network = name == "--clock" && options.timeline != Timeline::None;
    if (option->where == Where::Network || needs_network) network_only = name;
  }
  if (options.over_network() && !virtual_only.empty()) {
    refuse(virtual_only, "given", "has no meaning with --listen or --connect");
  }
  if (!options.over_network() && !network_only.empty()) {
    refuse(network_only, "given", "needs --listen or --connect");
  }
  if (options.over_network() && !options.udp() && options.timeline == Timeline::None) {
    refuse("--clock", "none", "over a network needs --key or --insecure");
  }
  if (!options.key.empty() && options.insecure) {
    refuse("--insecure", "given", "has no meaning with --key");
  }
  if (options.wire == Wire::Udp && options.key.empty() && !options.insecure) {
    refuse("--transport", "udp", "needs --key or --insecure");
  }
  options.endless = options.view.has_value() && !timed;
  for (const auto& [name, file] : {std::pair{"--json", &options.json},
                                   {"--csv", &options.csv},
                                   {"--record", &options.record},
                                   {"--record", &options.glb}}) {
    if (options.endless && !file->empty()) refuse(name, *file, "with --view needs --seconds");
  }
  // Users' scripts are made for a length.
  if (options.endless) options.seconds = kEndless;
  // Who waits is user A, who calls is user B.
  if (options.over_network() && options.peer_id == 0) {
    options.peer_id = options.connect.empty() ? 1 : 2;
  }
  return options;
}

}  // namespace tandem::demos
