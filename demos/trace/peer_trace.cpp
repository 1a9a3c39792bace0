// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/peer_trace.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include "session/run_arguments.h"
#include "trace/build_facts.h"

namespace tandem::demos {

namespace {

std::FILE* open_file(const std::string& path) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) throw std::system_error(errno, std::generic_category(), "--trace = " + path);
  // Unbuffered: a crash loses buffered output.
  std::setvbuf(file, nullptr, _IONBF, 0);
  return file;
}

}  // namespace

TraceHeader trace_header(const Scenario& scenario, const DemoOptions& options, consensus::PeerId id,
                         std::size_t number) {
  const Scene scene = scenario.build({});
  TraceHeader header;
  header.scene = scenario.name();
  header.arguments = run_arguments(options);
  header.self = id;
  header.number = number;
  header.scene_hash = scene_hash(scene);
  header.bodies = static_cast<std::uint32_t>(scene.bodies.size());
  header.build = build_facts();
  return header;
}

PeerTrace::PeerTrace(const TraceHeader& header, const std::string& path,
                     consensus::Transport& inner)
    : path_(path), file_(open_file(path)), writer_(header), transport_(inner, *this) {
  flush();
}

PeerTrace::~PeerTrace() {
  if (file_ != nullptr) std::fclose(file_);
}

void PeerTrace::close() {
  record_.kind = TraceKind::End;
  record_.steps = steps_;
  put(record_);
  if (file_ != nullptr) std::fclose(file_);
  file_ = nullptr;
}

void PeerTrace::user(std::size_t user, consensus::SessionTime epoch) {
  record_.user = static_cast<std::uint32_t>(user);
  phase(TraceKind::User, epoch);
}

void PeerTrace::rules(const DemoOptions& options) {
  transport_.begin_phase();
  record_.kind = TraceKind::Rules;
  record_.arguments = run_arguments(options);
  put(record_);
}

void PeerTrace::inputs(std::span<const Input> inputs) {
  if (inputs.empty()) return;
  record_.kind = TraceKind::Inputs;
  record_.user = inputs.front().user;
  record_.inputs.assign(inputs.begin(), inputs.end());
  put(record_);
}

void PeerTrace::solved() {
  hashes_.solved();
  record_.kind = TraceKind::Solved;
  record_.targets = hashes_.targets();
  record_.poses = hashes_.poses();
  put(record_);
  ++steps_;
}

void PeerTrace::sent() {
  record_.kind = TraceKind::Sent;
  record_.sent = transport_.sent().take();
  put(record_);
}

void PeerTrace::packets(std::uint64_t call, std::span<const consensus::Packet> packets) {
  writer_.write_packets(call, packets);
  flush();
}

void PeerTrace::answer(const TraceRecord& record) { put(record); }

void PeerTrace::phase(TraceKind kind, consensus::SessionTime time) {
  transport_.begin_phase();
  record_.kind = kind;
  record_.time = time;
  put(record_);
}

void PeerTrace::put(const TraceRecord& record) {
  writer_.write(record);
  flush();
}

void PeerTrace::flush() {
  const std::span<const std::byte> bytes = writer_.bytes();
  const bool written =
      file_ == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size();
  if (!written) {
    trouble_ = path_ + ": " + std::strerror(errno);
    std::fclose(file_);
    file_ = nullptr;
  }
  writer_.clear();
}

std::unique_ptr<PeerTrace> open_trace(const Scenario& scenario, const DemoOptions& options,
                                      consensus::PeerId id, std::size_t number,
                                      consensus::Transport& inner, bool one_of_many) {
  if (options.trace.empty()) return nullptr;
  std::string path = options.trace;
  if (one_of_many) path.append(1, '.').append(std::to_string(id));
  return std::make_unique<PeerTrace>(trace_header(scenario, options, id, number), path, inner);
}

void close_trace(PeerTrace* trace) {
  if (trace == nullptr) return;
  trace->close();
  if (trace->trouble().empty()) return;
  std::fprintf(stderr, "the trace is not complete: %s\n", trace->trouble().c_str());
}

}  // namespace tandem::demos
