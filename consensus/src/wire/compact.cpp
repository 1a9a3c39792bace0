// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/compact.h"

#include <array>
#include <cmath>

#include "tandem/pbd/bit_cast.h"
#include "tandem/pbd/bits.h"
#include "wire/compact_wire.h"

namespace tandem::consensus {
namespace {

using pbd::BitReader;
using pbd::BitWriter;
using pbd::ByteReader;
using pbd::ByteWriter;
using pbd::Quat;
using pbd::Vec3;
using Int3 = Eigen::Vector3i;

// Widths in bits, as docs/protocol.md has them.
constexpr unsigned kIndexBits = 16;
constexpr unsigned kNearGapBits = 4;
constexpr unsigned kCellBits = 20;
constexpr unsigned kPositionBits = 18;
constexpr unsigned kComponentBits = 15;
constexpr unsigned kLinearBits = 17;
constexpr unsigned kAngularBits = 16;
constexpr unsigned kFloatBits = 32;
constexpr unsigned kInfluenceBits = 16;
/// Flags that are seldom set, as bits of pack().
constexpr unsigned kRareBits = 4;
constexpr unsigned kRareFrom = 1;

constexpr std::int32_t kNearGaps = 1 << kNearGapBits;
constexpr std::int32_t kHalfCell = 1 << (kPositionBits - 1);  // in quanta
constexpr std::int32_t kMaxComponent = (1 << (kComponentBits - 1)) - 1;
constexpr std::int32_t kMaxLinear = (1 << (kLinearBits - 1)) - 1;
constexpr std::int32_t kMaxAngular = (1 << (kAngularBits - 1)) - 1;
/// Squares of the three smallest components sum up to at most 3/4; rounding adds 3 * 2 * 1/2 * half
/// a quantum to first order.
constexpr double kMaxSquares = 0.75 + 1e-4;

/// A state as quantised on the wire. Comparable, since records contain what has changed.
struct Lattice {
  Int3 cell = Int3::Zero();
  Int3 offset = Int3::Zero();  ///< quanta from the middle of the cell, -kHalfCell to kHalfCell - 1
  unsigned largest = 0;
  Int3 components = Int3::Zero();
  bool fast = false;  ///< velocities are sent as floats
  Int3 linear = Int3::Zero();
  Int3 angular = Int3::Zero();
  std::uint16_t influence = 0;
};

std::int32_t whole_of(double value) { return static_cast<std::int32_t>(std::lround(value)); }

/// @param cell  used if the position lies in it
Lattice to_lattice(const StateUpdate& update, const Int3& cell) {
  Lattice out;
  out.cell = cell;
  for (int k = 0; k < 3; ++k) {
    // Exact: multiples of a power of two.
    const std::int64_t whole = std::llround(update.pose.position[k] / kPositionQuantum);
    const auto offset_from = [whole](std::int32_t c) {
      return whole - std::int64_t{c} * (2 * kHalfCell);
    };
    if (offset_from(cell[k]) < -kHalfCell || offset_from(cell[k]) >= kHalfCell) {
      const double middle = (static_cast<double>(whole) + kHalfCell) / (2.0 * kHalfCell);
      out.cell[k] = static_cast<std::int32_t>(std::floor(middle));
    }
    out.offset[k] = static_cast<std::int32_t>(offset_from(out.cell[k]));
  }
  const Quat& q = update.pose.orientation;
  std::array<double, 4> c = {q.w(), q.x(), q.y(), q.z()};
  for (unsigned i = 1; i < 4; ++i) {
    if (std::abs(c[i]) > std::abs(c[out.largest])) out.largest = i;
  }
  // q and -q are the same rotation. A slightly wrong norm must not push components out of range.
  const double scale = std::copysign(1.0 / q.norm(), c[out.largest]) / kOrientationQuantum;
  for (unsigned i = 0, k = 0; i < 4; ++i) {
    if (i != out.largest) out.components[k++] = whole_of(scale * c[i]);
  }
  const double most_linear = (kMaxLinear + 0.5) * kLinearSpeedQuantum;
  const double most_angular = (kMaxAngular + 0.5) * kAngularSpeedQuantum;
  out.fast = !(update.twist.linear.cwiseAbs().maxCoeff() < most_linear &&
               update.twist.angular.cwiseAbs().maxCoeff() < most_angular);
  for (int k = 0; k < 3 && !out.fast; ++k) {
    out.linear[k] = whole_of(update.twist.linear[k] / kLinearSpeedQuantum);
    out.angular[k] = whole_of(update.twist.angular[k] / kAngularSpeedQuantum);
  }
  out.influence = static_cast<std::uint16_t>(
      std::lround(static_cast<double>(update.influence) / kInfluenceQuantum));
  return out;
}

Vec3 scaled(const Int3& value, double quantum) { return quantum * value.cast<double>(); }

Vec3 position_of(const Int3& cell, const Int3& offset) {
  return scaled(cell, kCellEdge) + scaled(offset, kPositionQuantum);
}

/// @return whether the components can be those of a unit quaternion
bool orientation_of(unsigned largest, const Int3& components, Quat& out) {
  const Vec3 small = scaled(components, kOrientationQuantum);
  const double squares = small.squaredNorm();
  if (!(squares <= kMaxSquares)) return false;
  std::array<double, 4> c{};
  c[largest] = std::sqrt(1.0 - squares);
  for (unsigned i = 0, k = 0; i < 4; ++i) {
    if (i != largest) c[i] = small[k++];
  }
  out = Quat(c[0], c[1], c[2], c[3]);
  return true;
}

float influence_of(std::uint16_t value) { return static_cast<float>(value * kInfluenceQuantum); }

/// Not inlined: when g++ 12 vectorises several of these conversions at -O3, it drops some.
[[gnu::noinline]] double as_float(double value) { return static_cast<float>(value); }

void round_with(const Lattice& lattice, StateUpdate& update) {
  update.pose.position = position_of(lattice.cell, lattice.offset);
  orientation_of(lattice.largest, lattice.components, update.pose.orientation);
  if (update.flags.resting) {
    update.twist = {};
  } else if (lattice.fast) {
    for (int i = 0; i < 3; ++i) {
      update.twist.linear[i] = as_float(update.twist.linear[i]);
      update.twist.angular[i] = as_float(update.twist.angular[i]);
    }
  } else {
    update.twist.linear = scaled(lattice.linear, kLinearSpeedQuantum);
    update.twist.angular = scaled(lattice.angular, kAngularSpeedQuantum);
  }
  update.influence = influence_of(lattice.influence);
  update.rounded = true;
}

/// The values that a record is relative to.
struct Before {
  std::int32_t index = -1;  ///< of the preceding record
  Int3 cell = Int3::Zero();
  std::uint16_t influence = 0;  ///< that of the message
};

/// Counts the bits that BitWriter would write.
struct BitCounter {
  unsigned bits = 0;
  void put(std::uint64_t /*value*/, unsigned count) { bits += count; }
  void put_signed(std::int64_t /*value*/, unsigned count) { bits += count; }
};

template <class Writer>
void put3(Writer& out, const Int3& value, unsigned bits) {
  for (const std::int32_t component : value) out.put_signed(component, bits);
}

template <class Writer>
void put_floats(Writer& out, const Vec3& value) {
  for (int i = 0; i < 3; ++i) {
    const auto number = static_cast<float>(value[i]);
    out.put(pbd::bit_cast<std::uint32_t>(number), kFloatBits);
  }
}

template <class Writer>
void write_record(Writer& out, const IndexedState& state, const Lattice& lattice,
                  const Before& before) {
  const std::int32_t gap = state.index - before.index;
  out.put(gap == 1 ? 0 : 1, 1);
  if (gap != 1) {
    const bool far = gap - 2 >= kNearGaps;
    out.put(far ? 1 : 0, 1);
    out.put(static_cast<std::uint64_t>(gap - 2), far ? kIndexBits : kNearGapBits);
  }
  const UpdateFlags& flags = state.update.flags;
  out.put(flags.resting ? 1 : 0, 1);
  out.put(flags.in_contact ? 1 : 0, 1);
  const unsigned rare = pack(flags) >> kRareFrom & ((1U << kRareBits) - 1);
  out.put(rare != 0 ? 1 : 0, 1);
  if (rare != 0) out.put(rare, kRareBits);
  const bool other_influence = lattice.influence != before.influence;
  out.put(other_influence ? 1 : 0, 1);
  if (other_influence) out.put(lattice.influence, kInfluenceBits);
  const bool other_cell = lattice.cell != before.cell;
  out.put(other_cell ? 1 : 0, 1);
  if (other_cell) put3(out, lattice.cell, kCellBits);
  put3(out, lattice.offset, kPositionBits);
  out.put(state.update.oriented ? 1 : 0, 1);
  if (state.update.oriented) {
    out.put(lattice.largest, 2);
    put3(out, lattice.components, kComponentBits);
  }
  if (flags.resting) return;
  out.put(lattice.fast ? 1 : 0, 1);
  if (lattice.fast) {
    put_floats(out, state.update.twist.linear);
    put_floats(out, state.update.twist.angular);
  } else {
    put3(out, lattice.linear, kLinearBits);
    put3(out, lattice.angular, kAngularBits);
  }
}

Int3 get3(BitReader& in, unsigned bits) {
  Int3 out;
  for (std::int32_t& component : out) component = static_cast<std::int32_t>(in.get_signed(bits));
  return out;
}

Vec3 get_floats(BitReader& in) {
  Vec3 out;
  for (int i = 0; i < 3; ++i) {
    out[i] = pbd::bit_cast<float>(static_cast<std::uint32_t>(in.get(kFloatBits)));
  }
  return out;
}

CodecResult read_record(BitReader& in, Before& before, CompactState& out) {
  std::int32_t gap = 1;
  if (in.flag()) gap = 2 + static_cast<std::int32_t>(in.get(in.flag() ? kIndexBits : kNearGapBits));
  before.index += gap;
  if (before.index > 0xffff) return fault(PacketFault::BadId, "index: must be below 65536");
  out.index = static_cast<std::uint16_t>(before.index);
  StateUpdate& update = out.update;
  update.rounded = true;
  const bool resting = in.flag();
  const bool in_contact = in.flag();
  if (in.flag()) update.flags = unpack(in.get(kRareBits) << kRareFrom);
  update.flags.resting = resting;
  update.flags.in_contact = in_contact;
  const bool other_influence = in.flag();
  update.influence = influence_of(
      other_influence ? static_cast<std::uint16_t>(in.get(kInfluenceBits)) : before.influence);
  if (in.flag()) before.cell = get3(in, kCellBits);
  update.pose.position = position_of(before.cell, get3(in, kPositionBits));
  update.oriented = in.flag();
  if (update.oriented) {
    const auto largest = static_cast<unsigned>(in.get(2));
    const Int3 components = get3(in, kComponentBits);
    for (const std::int32_t component : components) {
      if (component < -kMaxComponent) {
        return fault(PacketFault::BadCode, "orientation: components must be at least -16383");
      }
    }
    if (!orientation_of(largest, components, update.pose.orientation)) {
      return fault(PacketFault::OutOfRange, "orientation: components must be the smallest three");
    }
  }
  if (!update.flags.resting) {
    const bool fast = in.flag();
    update.twist.linear =
        fast ? get_floats(in) : scaled(get3(in, kLinearBits), kLinearSpeedQuantum);
    update.twist.angular =
        fast ? get_floats(in) : scaled(get3(in, kAngularBits), kAngularSpeedQuantum);
  }
  if (in.failed()) return fault(PacketFault::BadLength, "message: must hold all its records");
  return check_state(update);
}

}  // namespace

std::size_t encode_compact(std::span<IndexedState> states, std::uint32_t table,
                           std::size_t max_bytes, std::vector<std::byte>& out) {
  if (states.empty()) return 0;
  const std::size_t start = out.size();
  write_header(out, MessageKind::CompactStates, 0);
  ByteWriter bytes(out);
  Before before;
  // Most states have the same influence as the first.
  if (check_state(states[0].update).ok()) {
    before.influence = to_lattice(states[0].update, before.cell).influence;
  }
  bytes.i64(states[0].update.stamp);
  bytes.u32(table);
  bytes.u16(before.influence);
  const std::size_t length_at = out.size();
  bytes.u16(0);
  const std::size_t first_bit = 8 * (out.size() - start);
  std::size_t used = first_bit;
  std::size_t count = 0;
  std::size_t done = 0;
  BitWriter bits(out);
  for (; done < states.size() && count < kMaxRecords; ++done) {
    IndexedState& state = states[done];
    if (!check_state(state.update).ok()) continue;
    const Lattice lattice = to_lattice(state.update, before.cell);
    BitCounter record;
    write_record(record, state, lattice, before);
    const std::size_t needs = used + record.bits;
    if (start + (needs + 7) / 8 > max_bytes) break;
    // Rounding may leave the range at its edge.
    round_with(lattice, state.update);
    if (!check_state(state.update).ok()) continue;
    write_record(bits, state, lattice, before);
    used = needs;
    before.index = state.index;
    before.cell = lattice.cell;
    ++count;
  }
  bits.finish();
  if (count == 0) {
    out.resize(start);
    return done;
  }
  put_u16(out, start + kHeaderBytes - 2, count);
  put_u16(out, length_at, (used - first_bit + 7) / 8);
  return done;
}

CodecResult decode_compact(ByteReader& in, std::size_t count, std::vector<CompactState>& out) {
  const SessionTime stamp = in.i64();
  const std::uint32_t table = in.u32();
  Before before;
  before.influence = in.u16();
  const std::size_t length = in.u16();
  BitReader bits(in.bytes(length));
  if (in.failed()) return fault(PacketFault::BadLength, "message: must hold all its records");
  if (CodecResult result = check(Alive{stamp}); !result.ok()) return result;
  for (std::size_t i = 0; i < count; ++i) {
    CompactState& state = out.emplace_back();
    state.table = table;
    state.update.stamp = stamp;
    const CodecResult result = read_record(bits, before, state);
    if (!result.ok()) return result;
  }
  if (!bits.at_end())
    return fault(PacketFault::BadLength, "message: must end with its last record");
  return {};
}

}  // namespace tandem::consensus
