// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arguments/arguments.h"
#include "session/ablation.h"
#include "session/physics.h"
#include "session/session_key.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"

namespace tandem::demos {

/// How copies are kept together: a coupling, and the prediction and rules of influence before it.
enum class Scheme : std::uint8_t {
  OnePass,
  TwoStepPaper,  ///< as published: sleeping thresholds, linear extrapolation, constant share
  TwoStep,       ///< without thresholds and with all that one-pass has but the pass
  None,          ///< users' springs alone
  SingleOwner,   ///< with linear extrapolation
};

/// Where session time comes from over UDP; over TCP it is the system clock's. In virtual time it is
/// nobody's trouble, but None reads stamps as it does over UDP.
enum class Timeline : std::uint8_t {
  Session,  ///< the session's own, agreed on in band
  System,   ///< the system clock of hosts that PTP or NTP disciplines
  None,     ///< each peer has its own, and what comes is dated on receipt
};

enum class Wire : std::uint8_t {
  Auto,  ///< UDP with a key or `insecure`, TCP else
  Tcp,
  Udp,
  Nats,  ///< through servers; of tandem-peer alone, in builds with tandem::nats
};

/// What a run says on the terminal.
enum class Print : std::uint8_t {
  Nothing,  ///< not even how far it is
  Story,    ///< what happened, in words
  Details,  ///< all measures
};

/// What all demos understand on their command line.
struct DemoOptions {
  int peers = 2;
  double seconds = 20.0;      ///< s, of session time
  std::uint64_t seed = 1;     ///< of noise, orders, step phases, users and links
  bool equal_starts = false;  ///< no noise, and all peers add bodies in one order
  double influence = 0.08;    ///< baseline share per 1/60 s; 0 = no agreement
  /// nullopt = the scheme's: Euler in what is reproduced as published, else Replay.
  std::optional<consensus::PredictorKind> predictor;
  consensus::ReplayOptions replayed = {};
  consensus::InputMode mode = consensus::InputMode::Soft;
  Scheme scheme = Scheme::OnePass;
  double update_hz = 60.0;
  int profile = 3;  ///< of the virtual link, [friston] Table 3; 0 = nothing is late
  static constexpr consensus::PeerId kOnNetwork = 2;
  /// One of consensus::named_networks(), between peer kOnNetwork and all others; "" = as the rest.
  std::string network;
  bool off_grid = false;  ///< virtual peers step at times of their own, though they share a clock
  std::vector<double> rates = {60.0};              ///< steps each second of the peers, in turn
  std::vector<Engine> engines = {Engine::Tandem};  ///< of the peers, in turn
  std::optional<int> bullet_iterations;            ///< nullopt = Bullet's default, 10
  pbd::SolverOptions solver = {};                  ///< of peers on Tandem
  Ablation ablation;                               ///< parts that the run does without
  std::string variant;                             ///< of the scenario; "" = its default
  double loss = 0.0;                        ///< of the virtual link: chance that a state is lost
  double duplicate = 0.0;                   ///< chance that it comes twice
  double reorder = 0.0;                     ///< chance that it is overtaken
  double bandwidth = 0.0;                   ///< bit/s in each direction; 0 = unlimited
  std::size_t max_state_bytes = 64 * 1024;  ///< bytes of the longest state
  double clock_spread = 0.0;                ///< s, from one virtual peer's clock to the next one's
  bool compact = false;                     ///< states are rounded to few bits
  double budget = 0.0;  ///< kbit/s that a peer sends to each of the others; 0 = no limit
  double interest_radius =
      0.0;                 ///< m: others are told of what is near their users; 0 = of everything
  double tolerance = 0.0;  ///< m, of what the others expect: above it a state is sent; 0 = always

  std::optional<std::uint16_t> listen;  ///< one peer of several processes, accepts others here
  std::vector<std::string> connect;     ///< "HOST:PORT" of other processes
  std::vector<std::string> servers;     ///< "HOST:PORT" of NATS servers, of one cluster
  std::uint64_t peer_id = 0;            ///< of this process
  double wait = 0.0;     ///< s, how long to wait for the first other process; 0 = for ever
  std::string key;       ///< file with the session's key, 64 hex digits; "" = this machine alone
  std::string identity;  ///< file with this peer's secret key, beside `key`; "" = a new one
  std::vector<std::pair<std::uint64_t, Key>> trusted;  ///< public keys of all others; none = any
  std::optional<Key> organiser;  ///< public key; his certificates let others in
  std::string certificate;       ///< file with this peer's, hex
  bool insecure = false;         ///< on this machine alone; UDP with a key that everybody knows
  Wire wire = Wire::Auto;
  Timeline timeline = Timeline::Session;

  std::string json;                ///< file for the result, "-" = standard output, "" = none
  std::string csv;                 ///< folder for tables, "" = none
  std::string record;              ///< file for what the users did, "" = none
  std::string glb;                 ///< file for the run as glTF, "" = none
  std::string replay;              ///< file with what the users do, "" = they follow their script
  std::vector<std::string> hands;  ///< files, user i's hand does what the i-th has (docs/hands.md)
  std::string trace;               ///< file for what enters a peer, see docs/trace.md, "" = none
  bool reference = false;          ///< run the same inputs at one peer as well, and compare
  Print print = Print::Story;
  std::optional<Scheme>
      beside;          ///< what the run is shown beside; nullopt = what the scene proposes
  bool alone = false;  ///< it is shown beside nothing
  std::optional<std::uint16_t> view;       ///< serve a page that shows the run; 0 = any port
  std::string view_address = "127.0.0.1";  ///< numeric
  bool no_script = false;                  ///< nobody acts but from a page
  bool endless = false;                    ///< until it is stopped; `seconds` is the script's

  bool over_network() const { return wire == Wire::Nats || listen.has_value() || !connect.empty(); }
  bool quiet() const { return print == Print::Nothing; }
  bool udp() const { return wire == Wire::Auto ? !key.empty() || insecure : wire == Wire::Udp; }
  /// Whether virtual peers step at times that no common clock gives them.
  bool steps_off_grid() const { return off_grid || timeline == Timeline::None; }
  /// Steps each second of the peer of that number, from 0.
  double step_hz(std::size_t peer) const { return rates[peer % rates.size()]; }
  Engine engine(std::size_t peer) const { return engines[peer % engines.size()]; }
  /// Another engine has no pass that targets could be in, and is not asked for forces: it takes two
  /// steps by the same rules.
  Scheme scheme_of(std::size_t peer) const;
  consensus::PeerOptions peer_options() const { return peer_options(scheme); }
  /// The same for a peer that does it another way.
  consensus::PeerOptions peer_options(Scheme other) const;
  /// What is used, as given or as the scheme has it.
  consensus::PredictorKind predictor_kind() const { return peer_options().predictor; }
  consensus::LinkOptions link_options() const;
  /// Give all links of the virtual peers 1 to `peers` what they are to have.
  void set_links(consensus::VirtualNetwork& links) const;
};

/// Reads the arguments after the program's name. @throws UsageError
DemoOptions parse_options(std::span<const std::string_view> arguments);

/// Before a long run, whether its results can be written. @throws UsageError
void check_results(const DemoOptions& options);

/// The text for --help: what is used most, with examples.
std::string usage(std::string_view program);
/// The text for --help-all.
std::string usage_of_all(std::string_view program);

std::string_view to_string(consensus::PredictorKind kind);
std::string_view to_string(Scheme scheme);
std::string_view to_string(consensus::InputMode mode);

}  // namespace tandem::demos
