// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/diff.h"

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "trace/transports.h"

namespace tandem::demos {

namespace {

bool same(const Input& a, const Input& b) {
  const auto bits = [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  };
  return a.kind == b.kind && a.object == b.object && a.body == b.body &&
         std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(), bits);
}

bool same(const consensus::Packet& a, const consensus::Packet& b) {
  return a.from == b.from && a.received == b.received && a.role == b.role && a.bytes == b.bytes;
}

const char* stage_of(TraceKind kind) {
  switch (kind) {
    case TraceKind::Packets:
      return "packets";
    case TraceKind::Inputs:
    case TraceKind::User:
      return "inputs";
    case TraceKind::Peers:
    case TraceKind::Limit:
    case TraceKind::Refused:
      return "transport";
    case TraceKind::Sent:
      return "sent";
    case TraceKind::Rules:
      return "rules";
    default:
      return "times";
  }
}

std::optional<Departure> differ_if(bool differs, TraceKind kind, const char* note = "") {
  if (!differs) return std::nullopt;
  Departure result;
  result.stage = stage_of(kind);
  result.note = note;
  return result;
}

std::optional<Departure> packets_differ(const TraceRecord& a, const TraceRecord& b) {
  Departure result;
  result.stage = stage_of(a.kind);
  const std::size_t both = std::min(a.packets.size(), b.packets.size());
  for (std::size_t i = 0; i < both; ++i) {
    const consensus::Packet& x = a.packets[i];
    const consensus::Packet& y = b.packets[i];
    if (same(x, y)) continue;
    result.note = "packet " + std::to_string(i) + " from peer " + std::to_string(x.from) + ", ";
    if (x.bytes == y.bytes) {
      result.note += "its sender or when it came";
      return result;
    }
    const auto at = std::mismatch(x.bytes.begin(), x.bytes.end(), y.bytes.begin(), y.bytes.end());
    result.note += "byte " + std::to_string(at.first - x.bytes.begin()) + " of " +
                   std::to_string(x.bytes.size());
    return result;
  }
  const bool as_many = a.packets.size() == b.packets.size();
  if (as_many && a.call == b.call) return std::nullopt;
  result.note = as_many ? "the call that they came with"
                        : std::to_string(a.packets.size()) + " have come, or " +
                              std::to_string(b.packets.size());
  return result;
}

std::optional<Departure> inputs_differ(const TraceRecord& a, const TraceRecord& b) {
  Departure result;
  result.stage = stage_of(a.kind);
  result.note = "of user " + std::to_string(a.user);
  if (a.user != b.user) return result;
  const std::size_t both = std::min(a.inputs.size(), b.inputs.size());
  for (std::size_t i = 0; i < both; ++i) {
    if (same(a.inputs[i], b.inputs[i])) continue;
    if (a.inputs[i].kind != Input::Kind::Signal) result.body = a.inputs[i].body;
    return result;
  }
  if (a.inputs.size() == b.inputs.size()) return std::nullopt;
  return result;
}

/// Compares two records of the same kind.
std::optional<Departure> difference(const TraceRecord& a, const TraceRecord& b) {
  switch (a.kind) {
    case TraceKind::Packets:
      return packets_differ(a, b);
    case TraceKind::Inputs:
      return inputs_differ(a, b);
    case TraceKind::Peers:
      return differ_if(a.call != b.call || !same_in_trace(a.peers, b.peers), a.kind,
                       "what it said of other peers");
    case TraceKind::Limit:
      return differ_if(a.call != b.call || a.delivery != b.delivery || a.bytes != b.bytes, a.kind,
                       "its longest packet");
    case TraceKind::Refused:
      return differ_if(a.call != b.call, a.kind, "a packet that it did not take");
    case TraceKind::Solved: {
      std::optional<Departure> result = compare(a.targets, b.targets, "targets");
      return result ? result : compare(a.poses, b.poses, "poses");
    }
    case TraceKind::Sent:
      return differ_if(a.sent != b.sent, a.kind);
    case TraceKind::Rules:
      return differ_if(a.arguments != b.arguments, a.kind);
    case TraceKind::End:
      return std::nullopt;
    default:
      return differ_if(a.time != b.time || (a.kind == TraceKind::User && a.user != b.user), a.kind);
  }
}

/// Positions after a step.
struct Frame {
  consensus::SessionTime time = 0;
  std::vector<pbd::Vec3> positions;
};

void look(const Replayer& replayer, Frame& frame) {
  frame.time = replayer.time();
  frame.positions.clear();
  for (const SceneBody& body : replayer.scene().bodies) {
    frame.positions.push_back(replayer.scene().pose(body).position);
  }
}

}  // namespace

std::optional<Departure> first_difference(TraceReader& a, TraceReader& b) {
  TraceRecord x;
  TraceRecord y;
  std::uint64_t step = 0;
  consensus::SessionTime begun = 0;
  while (a.next(x) && b.next(y)) {
    std::optional<Departure> result;
    if (x.kind == y.kind) {
      result = difference(x, y);
    } else if (x.kind != TraceKind::End && y.kind != TraceKind::End) {
      // One trace has an additional record: it is named by the trace whose phase goes on.
      const TraceKind one = begins_phase(x.kind) ? y.kind : x.kind;
      result = differ_if(true, one, "in one of them alone");
    }
    if (x.kind == TraceKind::Begin) begun = x.time;
    if (result) {
      result->step = x.kind == TraceKind::Sent && step > 0 ? step - 1 : step;
      result->time = begun;
      return result;
    }
    if (x.kind == TraceKind::Solved) ++step;
  }
  return std::nullopt;
}

TwoViews compare_views(const Scenario& scenario, std::span<const std::byte> a,
                       std::span<const std::byte> b, double tolerance) {
  Replayer first(scenario, a);
  Replayer second(scenario, b);
  TwoViews result;
  Frame here;
  Frame before;
  Frame after;
  while (first.next_step()) {
    look(first, here);
    while (after.time < here.time && second.next_step()) {
      std::swap(before, after);
      look(second, after);
    }
    if (after.time < here.time) break;
    if (before.time == 0 || before.time > here.time) continue;
    ++result.compared;
    const double part = static_cast<double>(here.time - before.time) /
                        static_cast<double>(after.time - before.time);
    for (std::size_t i = 0; i < here.positions.size(); ++i) {
      const pbd::Vec3 there =
          before.positions[i] + part * (after.positions[i] - before.positions[i]);
      const Apart apart{first.steps() - 1, here.time, i, (here.positions[i] - there).norm()};
      if (!result.beyond && apart.distance > tolerance) result.beyond = apart;
      if (!result.furthest || apart.distance > result.furthest->distance) result.furthest = apart;
    }
  }
  result.a = first.departure();
  result.b = second.departure();
  return result;
}

}  // namespace tandem::demos
