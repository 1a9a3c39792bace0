// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "rollback/wire.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tandem::rollback_bench {

namespace {

using demos::Input;

constexpr double kTurn = 32767.0;  // represents 1

bool has_pose(Input::Kind kind) { return kind == Input::Kind::Drive || kind == Input::Kind::Jump; }
bool names_both(Input::Kind kind) { return kind == Input::Kind::Grab || kind == Input::Kind::Hold; }

}  // namespace

void write(pbd::ByteWriter& out, const Inputs& inputs) {
  out.u8(static_cast<std::uint8_t>(inputs.size()));
  for (const Input& input : inputs) {
    out.u8(static_cast<std::uint8_t>(static_cast<unsigned>(input.kind) | input.user << 3));
    out.u16(static_cast<std::uint16_t>(input.object));
    if (names_both(input.kind)) out.u16(static_cast<std::uint16_t>(input.body));
    for (std::size_t i = 0; i < input.values.size(); ++i) {
      if (has_pose(input.kind) && i >= 3) {
        out.u16(static_cast<std::uint16_t>(std::lround(input.values[i] * kTurn)));
      } else {
        out.f32(static_cast<float>(input.values[i]));
      }
    }
  }
}

Inputs read(pbd::ByteReader& in) {
  Inputs inputs(in.u8());
  for (Input& input : inputs) {
    const std::uint8_t head = in.u8();
    input.kind = static_cast<Input::Kind>(head & 7u);
    input.user = head >> 3;
    input.object = in.u16();
    if (input.kind > Input::Kind::Signal) in.fail();
    if (in.failed()) return {};
    if (names_both(input.kind)) input.body = in.u16();
    if (has_pose(input.kind)) input.body = input.object;
    input.values.resize(demos::value_count(input.kind));
    for (std::size_t i = 0; i < input.values.size(); ++i) {
      const bool turn = has_pose(input.kind) && i >= 3;
      input.values[i] = turn ? static_cast<std::int16_t>(in.u16()) / kTurn : double{in.f32()};
    }
  }
  return inputs;
}

Inputs rounded(const Inputs& inputs) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  write(out, inputs);
  pbd::ByteReader in(bytes);
  return read(in);
}

bool same(const Inputs& a, const Inputs& b) {
  return a.size() == b.size() && std::all_of(a.begin(), a.end(), [&](const Input& one) {
           return std::any_of(b.begin(), b.end(), [&](const Input& other) {
             return one.kind == other.kind && one.user == other.user &&
                    one.object == other.object && one.body == other.body &&
                    one.values == other.values;
           });
         });
}

}  // namespace tandem::rollback_bench
