// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scenes/scenario.h"
#include "session/options.h"
#include "session/step_watch.h"
#include "trace/stage_hashes.h"
#include "trace/transports.h"
#include "trace/writer.h"

namespace tandem::demos {

TraceHeader trace_header(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
                         std::size_t number);

/// Records everything that happens to one peer: sits between it and its transport, and watches its
/// steps. Records are written before they take effect, so that a crash loses only the step's
/// hashes.
/// @par Thread safety  One object: the thread that steps the peer's world.
class PeerTrace final : public StepWatch, private TraceSink {
 public:
  /// @param path   of the file, which is replaced     @param inner  must outlive it
  /// @throws std::system_error if the file cannot be opened
  PeerTrace(const TraceHeader& header, const std::string& path, consensus::Transport& inner);
  ~PeerTrace() override;
  PeerTrace(const PeerTrace&) = delete;
  PeerTrace& operator=(const PeerTrace&) = delete;

  consensus::Transport& transport() { return transport_; }
  /// Marks the file as complete after the run. No further calls.
  void close();
  /// Why the file is incomplete; empty if it is complete. The run continues regardless.
  const std::string& trouble() const { return trouble_; }

  // StepWatch
  void attach(Scene& scene, consensus::Peer& peer) override { hashes_.attach(scene, peer); }
  void user(std::size_t user, consensus::SessionTime epoch) override;
  void rules(const DemoOptions& options) override;
  void begin(consensus::SessionTime now) override { phase(TraceKind::Begin, now); }
  void inputs(std::span<const Input> inputs) override;
  void told() override { hashes_.told(); }
  void step(consensus::SessionTime end) override { phase(TraceKind::Step, end); }
  void solved() override;
  void finish(consensus::SessionTime now) override { phase(TraceKind::Finish, now); }
  void leave(consensus::SessionTime now) override { phase(TraceKind::Leave, now); }
  void sent() override;

 private:
  // TraceSink
  void packets(std::uint64_t call, std::span<const consensus::Packet> packets) override;
  void answer(const TraceRecord& record) override;

  void phase(TraceKind kind, consensus::SessionTime time);
  void put(const TraceRecord& record);
  void flush();

  std::string path_;
  std::FILE* file_;
  std::string trouble_;
  TraceWriter writer_;
  TracingTransport transport_;
  StageHashes hashes_;
  TraceRecord record_;  ///< scratch, kept for its capacity
  std::uint64_t steps_ = 0;
};

/// The trace of --trace; null without that option.
/// @param one_of_many  other peers are in this process: "." and the id are appended to the file's
/// name
std::unique_ptr<PeerTrace> open_trace(const Scenario& scenario, const DemoOptions& options,
                                      consensus::PeerId id, std::size_t number,
                                      consensus::Transport& inner, bool one_of_many = false);

/// Ends a trace, with a warning on standard error if it is incomplete. @param trace  may be null
void close_trace(PeerTrace* trace);

}  // namespace tandem::demos
