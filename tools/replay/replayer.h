// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "replay/reader.h"
#include "scenes/scenario.h"
#include "session/options.h"
#include "session/participant.h"
#include "session/step_watch.h"
#include "trace/stage_hashes.h"
#include "trace/transports.h"

namespace tandem::demos {

/// The first difference of a replay, or of another run, from a trace.
struct Departure {
  std::uint64_t step = 0;           ///< from 0
  consensus::SessionTime time = 0;  ///< ns, of the step's beginning
  /// The first differing stage: "packets", "inputs", "targets", "poses", "sent" ..
  std::string stage;
  std::optional<std::size_t> body;  ///< the first one, index into the scene's bodies
  std::size_t bodies = 0;           ///< number of differing bodies
  std::string note;                 ///< further details; may be empty
};

/// For people. @param name  of the body; "" = none
std::string to_text(const Departure& departure, const std::string& name);

/// The first body with different hashes of one stage; nothing if all are equal.
std::optional<Departure> compare(const StageHash& a, const StageHash& b, const char* stage);

/// The options in a trace's header or Rules. @throws UsageError
DemoOptions traced_options(std::span<const std::string> arguments);

/// Replays a peer from its trace, and compares.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Replayer final : private StepWatch {
 public:
  /// Scenario and bytes must outlive it.
  /// @throws TraceError, UsageError or std::invalid_argument if the trace is invalid or of another
  ///   scenario
  Replayer(const Scenario& scenario, std::span<const std::byte> trace);
  ~Replayer() override;

  /// Runs to the end of the next step. False if there is none, or after a departure.
  /// @throws TraceError
  bool next_step();
  /// Number of computed steps.
  std::uint64_t steps() const { return steps_; }
  /// ns, end of the last step.
  consensus::SessionTime time() const { return end_; }
  /// The first difference from the trace; nothing if there is none.
  const std::optional<Departure>& departure() const { return departure_; }
  const Scene& scene() const { return participant_->scene(); }
  const TraceReader& reader() const { return reader_; }

 private:
  class TracedUser;

  const TraceHeader& header() const { return reader_.header(); }
  void load_phase();
  void run_phase();
  void run_driver();
  void depart(Departure departure);
  const TraceRecord* find(TraceKind kind) const;
  std::span<const TraceRecord> answers() const { return answers_; }

  // StepWatch
  void attach(Scene& scene, consensus::Peer& peer) override { hashes_.attach(scene, peer); }
  void told() override { hashes_.told(); }
  void solved() override;
  void sent() override;

  TraceReader reader_;
  DemoOptions options_;
  ReplayTransport transport_;
  StageHashes hashes_;
  TraceRecord driver_;                ///< begins the phase
  TraceRecord next_;                  ///< begins the next phase
  bool more_ = true;                  ///< next_ is valid
  std::vector<TraceRecord> answers_;  ///< of the phase
  std::unique_ptr<Participant> participant_;
  std::optional<Departure> departure_;
  std::uint64_t steps_ = 0;
  consensus::SessionTime begun_ = 0;
  consensus::SessionTime end_ = 0;
};

}  // namespace tandem::demos
