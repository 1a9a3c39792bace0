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

/// How copies are kept together: the coupling, its prediction and its rules of influence.
enum class Scheme : std::uint8_t {
  OnePass,
  TwoStepPaper,  ///< as published: sleeping thresholds, linear extrapolation, constant share
  TwoStep,       ///< without thresholds; differs from one-pass in the pass alone
  None,          ///< only users' springs
  SingleOwner,   ///< with linear extrapolation
};

/// Source of session time over UDP; TCP uses the system clock. In virtual time only None matters:
/// it reads stamps as it does over UDP.
enum class Timeline : std::uint8_t {
  Session,  ///< the session's own, agreed in band
  System,   ///< the system clock of hosts that PTP or NTP disciplines
  None,     ///< each peer has its own, and updates are dated on receipt
};

enum class Wire : std::uint8_t {
  Auto,  ///< UDP with a key or `insecure`, otherwise TCP
  Tcp,
  Udp,
  Nats,  ///< through servers; only for tandem-peer, in builds with tandem::nats
};

/// Output of a run on the terminal.
enum class Print : std::uint8_t {
  Nothing,  ///< not even progress
  Story,    ///< a summary in words
  Details,  ///< all measures
};

struct DemoOptions {
  int peers = 2;
  double seconds = 20.0;      ///< s, of session time
  std::uint64_t seed = 1;     ///< for noise, orders, step phases, users and links
  bool equal_starts = false;  ///< no noise, and the same order of bodies at all peers
  double influence = 0.08;    ///< baseline share per 1/60 s; 0 = no agreement
  /// nullopt = the scheme's: Euler for published methods, otherwise Replay.
  std::optional<consensus::PredictorKind> predictor;
  consensus::ReplayOptions replayed = {};
  consensus::InputMode mode = consensus::InputMode::Soft;
  Scheme scheme = Scheme::OnePass;
  double update_hz = 60.0;
  int profile = 3;  ///< of the virtual link, [friston] Table 3; 0 = no latency
  static constexpr consensus::PeerId kOnNetwork = 2;
  /// One of consensus::named_networks(), between peer kOnNetwork and all others; "" = none.
  std::string network;
  bool off_grid = false;  ///< virtual peers with a shared clock still step at their own times
  std::vector<double> rates = {60.0};              ///< steps per second of the peers, cyclically
  std::vector<Engine> engines = {Engine::Tandem};  ///< of the peers, cyclically
  std::optional<int> bullet_iterations;            ///< nullopt = Bullet's default, 10
  pbd::SolverOptions solver = {};                  ///< of peers on Tandem
  Ablation ablation;                               ///< parts that the run omits
  std::string variant;                             ///< of the scenario; "" = its default
  double loss = 0.0;                        ///< of the virtual link: chance that a state is lost
  double duplicate = 0.0;                   ///< chance that it is duplicated
  double reorder = 0.0;                     ///< chance that it is overtaken
  double bandwidth = 0.0;                   ///< bit/s in each direction; 0 = unlimited
  std::size_t max_state_bytes = 64 * 1024;  ///< bytes, of the largest state
  double clock_spread = 0.0;                ///< s, between the clocks of successive virtual peers
  bool compact = false;                     ///< states are rounded to few bits
  double budget = 0.0;                      ///< kbit/s from a peer to each other one; 0 = no limit
  double interest_radius = 0.0;  ///< m: send only bodies near the receivers' users; 0 = all
  double tolerance = 0.0;  ///< m, from the receivers' prediction: a larger error is sent; 0 = all

  std::optional<std::uint16_t> listen;  ///< one peer of several processes, accepts others here
  std::vector<std::string> connect;     ///< "HOST:PORT" of other processes
  std::vector<std::string> servers;     ///< "HOST:PORT" of NATS servers, of one cluster
  std::uint64_t peer_id = 0;            ///< of this process
  double wait = 0.0;                    ///< s, wait for the first other process; 0 = no limit
  std::string key;       ///< file with the session's key, 64 hex digits; "" = only this machine
  std::string identity;  ///< file with this peer's secret key, beside `key`; "" = a new one
  std::vector<std::pair<std::uint64_t, Key>> trusted;  ///< public keys of all others; none = any
  std::optional<Key> organiser;  ///< public key; its certificates admit others
  std::string certificate;       ///< file with this peer's, hex
  bool insecure = false;         ///< only this machine; UDP with a publicly known key
  Wire wire = Wire::Auto;
  Timeline timeline = Timeline::Session;

  std::string json;                ///< file for the result, "-" = standard output, "" = none
  std::string csv;                 ///< folder for tables, "" = none
  std::string record;              ///< file for the users' inputs, "" = none
  std::string glb;                 ///< file for the run as glTF, "" = none
  std::string replay;              ///< file with the users' inputs, "" = their script
  std::vector<std::string> hands;  ///< files, the i-th for user i's hand (docs/hands.md)
  std::string trace;               ///< file for a peer's inputs, see docs/trace.md, "" = none
  bool reference = false;          ///< also run the same inputs at one peer, and compare
  Print print = Print::Story;
  std::optional<Scheme> beside;            ///< comparison run; nullopt = the scene's proposal
  bool alone = false;                      ///< no comparison run
  std::optional<std::uint16_t> view;       ///< serve a page that shows the run; 0 = any port
  std::string view_address = "127.0.0.1";  ///< numeric
  bool no_script = false;                  ///< only users at pages act
  bool endless = false;                    ///< until stopped; `seconds` is the script's length

  bool over_network() const { return wire == Wire::Nats || listen.has_value() || !connect.empty(); }
  bool quiet() const { return print == Print::Nothing; }
  bool udp() const { return wire == Wire::Auto ? !key.empty() || insecure : wire == Wire::Udp; }
  /// True if virtual peers step at their own times.
  bool steps_off_grid() const { return off_grid || timeline == Timeline::None; }
  /// Step rate of peer number `peer`, from 0.
  double step_hz(std::size_t peer) const { return rates[peer % rates.size()]; }
  Engine engine(std::size_t peer) const { return engines[peer % engines.size()]; }
  /// Another engine has no pass for targets and no forces to report: it uses two-step with the same
  /// rules.
  Scheme scheme_of(std::size_t peer) const;
  consensus::PeerOptions peer_options() const { return peer_options(scheme); }
  /// The same for a peer with another scheme.
  consensus::PeerOptions peer_options(Scheme other) const;
  /// The given kind, or the scheme's.
  consensus::PredictorKind predictor_kind() const { return peer_options().predictor; }
  consensus::LinkOptions link_options() const;
  /// For virtual peers.
  void set_links(consensus::VirtualNetwork& links) const;
};

/// Reads the arguments after the program's name. @throws UsageError
DemoOptions parse_options(std::span<const std::string_view> arguments);

/// Checks before a long run that results can be written. @throws UsageError
void check_results(const DemoOptions& options);

/// The text for --help: common options, with examples.
std::string usage(std::string_view program);
/// The text for --help-all.
std::string usage_of_all(std::string_view program);

std::string_view to_string(consensus::PredictorKind kind);
std::string_view to_string(Scheme scheme);
std::string_view to_string(consensus::InputMode mode);

}  // namespace tandem::demos
