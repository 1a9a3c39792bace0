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

/// The header of a peer's trace.
TraceHeader trace_header(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
                         std::size_t number);

/// Writes down what happens to one peer: stands between it and its transport, and watches its
/// steps. Each record is in the file before what it tells has any effect, so that of a crash all is
/// there but the step's hashes.
/// @par Thread safety  One object: the thread that steps the peer's world.
class PeerTrace final : public StepWatch, private TraceSink {
 public:
  /// @param path   of the file, which is replaced     @param inner  must outlive it
  /// @throws std::system_error where the file cannot be opened
  PeerTrace(const TraceHeader& header, const std::string& path, consensus::Transport& inner);
  ~PeerTrace() override;
  PeerTrace(const PeerTrace&) = delete;
  PeerTrace& operator=(const PeerTrace&) = delete;

  /// To be handed to the peer.
  consensus::Transport& transport() { return transport_; }
  /// The run is over: says in the file that it is complete. No further calls.
  void close();
  /// Why the file is not complete; empty where all was written. The run goes on all the same.
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
  TraceRecord record_;  ///< scratch, kept for its memory
  std::uint64_t steps_ = 0;
};

/// As --trace asks for it; null where it is not given.
/// @param one_of_many  other peers are in this process: the file's name ends with "." and the id
std::unique_ptr<PeerTrace> open_trace(const Scenario& scenario, const DemoOptions& options,
                                      consensus::PeerId id, std::size_t number,
                                      consensus::Transport& inner, bool one_of_many = false);

/// Ends it and says on standard error where it is not complete. @param trace  may be null
void close_trace(PeerTrace* trace);

}  // namespace tandem::demos
