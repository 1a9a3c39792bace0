// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "rollback/rollback_peer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/pbd/cpu_timer.h"

namespace tandem::rollback_bench {

namespace {

using consensus::Delivery;
using demos::Input;

enum class Message : std::uint8_t { Inputs, Ask, Welcome };

pbd::SolverOptions solver_of(const demos::DemoOptions& demo, const RollbackOptions& options,
                             std::size_t number) {
  pbd::SolverOptions result = demo.solver;
  if (number == 1) result.substeps = options.other_substeps.value_or(result.substeps);
  return result;
}

}  // namespace

RollbackPeer::RollbackPeer(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                           const RollbackOptions& options, std::size_t number,
                           consensus::Transport& transport)
    : options_(options),
      number_(number),
      transport_(transport),
      world_(scenario, solver_of(demo, options, number)),
      view_(scenario, demo, number, options.smoothing),
      remotes_(static_cast<std::size_t>(demo.peers)),
      saved_(static_cast<std::size_t>(options.prediction_window + 2)) {
  for (Remote& remote : remotes_) remote.predicted.resize(saved_.size());
  remotes_[number].inputs.resize(static_cast<std::size_t>(options.input_delay));
  if (options.join == 0) return;
  // A newcomer has no input before it joins, and needs no earlier events.
  joined_ = !is_late(number);
  remotes_.back().inputs.resize(static_cast<std::size_t>(options.join + kJoinLead));
  remotes_.back().acknowledged = static_cast<std::size_t>(options.join - options.prediction_window);
}

void RollbackPeer::set_inputs(std::size_t peer, std::vector<Inputs> inputs) {
  remotes_[peer].inputs = std::move(inputs);
}

void RollbackPeer::tick(std::int64_t clock) {
  clock_ = clock;
  cpu_ = 0.0;
  receive();
  if (!joined_) {
    const std::byte message{static_cast<std::uint8_t>(Message::Ask)};
    if (clock == options_.join) post(0, std::span(&message, 1), Delivery::Reliable);
    return;
  }
  correct();
  int frames = 0;
  for (; frames < options_.max_frames_per_tick && frame_ <= clock_; ++frames) {
    if (frame_ - confirmed_ >= options_.prediction_window) break;
    sample_inputs();
    const pbd::CpuTimer timer(cpu_);
    simulate();
  }
  if (frames == 0 && frame_ <= clock_) ++stats_.stalled;
  {
    const pbd::CpuTimer timer(cpu_);
    send(frames);
    view_.smooth();
  }
  view_.keep(world_.scene(), frame_time(clock_ + 1));
  stats_.frame_ms.push_back(1e3 * cpu_);
}

/// Corrects for received inputs.
void RollbackPeer::correct() {
  const pbd::CpuTimer timer(cpu_);
  if (wrong_ < frame_) {
    view_.before_correction(world_.scene());
    roll_back();
    view_.after_correction(world_.scene());
  }
  wrong_ = INT64_MAX;
  confirm();
  for (std::size_t i = 0; i < remotes_.size(); ++i) {
    if (std::exchange(remotes_[i].asks_to_join, false)) welcome(i);
  }
}

void RollbackPeer::receive() {
  const pbd::CpuTimer timer(cpu_);
  std::vector<consensus::Packet> packets;
  transport_.drain(packets);
  for (const consensus::Packet& packet : packets) {
    const auto from = static_cast<std::uint32_t>(packet.from - 1);
    pbd::ByteReader in(packet.bytes);
    const auto message = static_cast<Message>(in.u8());
    if (message == Message::Inputs && joined_) read_inputs(from, in);
    if (message == Message::Ask) remotes_[from].asks_to_join = true;
    if (message == Message::Welcome) join(in);
  }
}

void RollbackPeer::read_inputs(std::uint32_t peer, pbd::ByteReader& in) {
  Remote& from = remotes_[peer];
  demos::PeerRecord& record = view_.record();
  record.first_exchange = std::min(record.first_exchange, frame_time(clock_));
  ++record.updates_received;
  from.acknowledged = std::max<std::size_t>(from.acknowledged, in.u32());
  in.u32();  // the newest confirmed frame there, and its hash: compared at the end of the run
  in.u32();
  const std::size_t first = in.u32();
  const std::size_t count = in.u8();
  for (std::size_t frame = first; frame < first + count && !in.failed(); ++frame) {
    Inputs inputs = read(in);
    if (frame != from.inputs.size() || in.failed()) continue;
    const auto at = static_cast<std::int64_t>(frame);
    if (at < frame_ && !same(inputs, from.predicted[ring(at)])) wrong_ = std::min(wrong_, at);
    from.inputs.push_back(std::move(inputs));
  }
}

void RollbackPeer::welcome(std::size_t newcomer) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  out.u8(static_cast<std::uint8_t>(Message::Welcome));
  out.u32(static_cast<std::uint32_t>(confirmed_));
  // The world in its final state.
  Replica::Saved now;
  world_.save(now);
  if (confirmed_ < frame_) world_.restore(saved_[ring(confirmed_)]);
  out.bytes(world_.snapshot());
  world_.restore(now);
  post(newcomer, bytes, Delivery::Reliable);
}

void RollbackPeer::join(pbd::ByteReader& in) {
  stats_.snapshot_bytes = in.remaining();
  const std::size_t known = in.u32();
  world_.restore(in);
  for (std::size_t i = 0; i < remotes_.size(); ++i) {
    if (i != number_) remotes_[i].inputs.resize(known);
    remotes_[i].acknowledged = remotes_[number_].inputs.size();
  }
  joined_ = true;
  frame_ = confirmed_ = static_cast<std::int64_t>(known);
}

void RollbackPeer::post(std::size_t to, std::span<const std::byte> bytes, Delivery delivery) {
  transport_.post(to + 1, bytes, delivery);
  view_.record().bytes_sent += bytes.size();
}

void RollbackPeer::send(int new_frames) {
  for (const consensus::PeerStatus& peer : transport_.peers()) {
    // A newcomer sends nothing before it asks to join.
    if (clock_ >= options_.join || !is_late(peer.id - 1))
      send_to(peer.id - 1, peer.round_trip, new_frames);
  }
}

void RollbackPeer::send_to(std::size_t to, std::int64_t round_trip, int new_frames) {
  constexpr double kSlack = 4.0;  // frames
  constexpr std::size_t kMost = 250;
  const std::vector<Inputs>& own = remotes_[number_].inputs;
  std::size_t first = remotes_[to].acknowledged;
  // A peer that catches up has several unsent frames.
  const auto newest = static_cast<std::size_t>(options_.redundancy + std::max(new_frames, 1) - 1);
  // Resend an input while it is new, or if its acknowledgement is overdue. A stalled peer has
  // nothing newer: the others may wait for exactly that.
  const double late = 1e-9 * static_cast<double>(round_trip) * kFrameHz + kSlack;
  const bool lost = new_frames == 0 || round_trip < 0 ||
                    static_cast<double>(own.size() - first) > late + static_cast<double>(newest);
  if (!lost && own.size() > newest) first = std::max(first, own.size() - newest);
  const std::size_t count = std::min(kMost, own.size() - std::min(first, own.size()));
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  out.u8(static_cast<std::uint8_t>(Message::Inputs));
  out.u32(static_cast<std::uint32_t>(remotes_[to].inputs.size()));
  out.u32(static_cast<std::uint32_t>(confirmed_));
  const auto confirmed = static_cast<std::size_t>(confirmed_);
  out.u32(static_cast<std::uint32_t>(confirmed < hashes_.size() ? hashes_[confirmed] : 0));
  out.u32(static_cast<std::uint32_t>(first));
  out.u8(static_cast<std::uint8_t>(count));
  for (std::size_t frame = first; frame < first + count; ++frame) write(out, own[frame]);
  post(to, bytes, Delivery::Newest);
}

void RollbackPeer::roll_back() {
  ++stats_.rollbacks;
  const std::int64_t end = frame_;
  world_.restore(saved_[ring(wrong_)]);
  for (frame_ = wrong_; frame_ < end;) simulate();
}

void RollbackPeer::sample_inputs() {
  std::vector<Inputs>& own = remotes_[number_].inputs;
  const auto at = static_cast<std::size_t>(frame_ + options_.input_delay);
  if (own.size() > at) return;
  Inputs inputs = view_.inputs(world_.scene(), frame_time(frame_), frame_duration(frame_));
  const pbd::CpuTimer timer(cpu_);
  for (Input& input : inputs) {
    // The time of a delayed event is unchanged by the input delay.
    if (input.kind == Input::Kind::Signal) input.values[0] -= options_.input_delay / kFrameHz;
  }
  own.resize(at);
  own.push_back(rounded(inputs));
}

void RollbackPeer::simulate() {
  const auto at = static_cast<std::size_t>(frame_);
  const bool known = std::all_of(remotes_.begin(), remotes_.end(),
                                 [&](const Remote& remote) { return remote.inputs.size() > at; });
  if (hashes_.size() <= at) hashes_.resize(at + 1);
  // Fully known frames are never rolled back to.
  if (known) {
    hashes_[at] = world_.hash();
  } else {
    world_.save(saved_[ring(frame_)]);
  }
  for (std::uint32_t i = 0; i < remotes_.size(); ++i) {
    Remote& remote = remotes_[i];
    if (at < remote.inputs.size()) {
      world_.apply(i, frame_, remote.inputs[at]);
      continue;
    }
    const std::size_t ahead = at - remote.inputs.size();
    const bool goes_on = ahead < static_cast<std::size_t>(options_.extrapolation);
    Inputs& predicted = remote.predicted[ring(frame_)];
    predicted = world_.predict(i, frame_, goes_on);
    world_.apply(i, frame_, predicted);
  }
  world_.step(frame_);
  ++stats_.steps;
  ++frame_;
}

void RollbackPeer::confirm() {
  std::int64_t known = frame_;
  for (const Remote& remote : remotes_) {
    known = std::min(known, static_cast<std::int64_t>(remote.inputs.size()));
  }
  hashes_.resize(static_cast<std::size_t>(frame_ + 1));
  while (confirmed_ < known) {
    const auto at = static_cast<std::size_t>(++confirmed_);
    if (hashes_[at] != 0) continue;
    hashes_[at] =
        confirmed_ == frame_ ? world_.hash() : saved_[ring(confirmed_)].world.world().hash();
  }
}

}  // namespace tandem::rollback_bench
