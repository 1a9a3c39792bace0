// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/reader.h"

#include <algorithm>
#include <string>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {

using consensus::SessionTime;

constexpr std::size_t kHeaderBytes = kTraceMagic.size() + 1 + 4;  // before the header's content
constexpr std::uint64_t kMaxRecord = std::uint64_t{1} << 30;
constexpr std::uint64_t kMaxText = 4096;
constexpr std::uint64_t kMaxBodies = 1'000'000;
constexpr std::uint64_t kMaxPackets = std::uint64_t{1} << 26;  // bytes, per phase
constexpr std::uint64_t kMinLimit = 128;  // bytes, the minimum of --link max-state
constexpr std::uint64_t kMaxLimit = std::uint64_t{1} << 32;
constexpr std::size_t kMaxUsers = 1024;
constexpr SessionTime kMaxTime = SessionTime{1} << 62;
constexpr SessionTime kMaxStep = 10'000'000'000;  // ns

}  // namespace

/// The content of one record, or of the header.
class TraceReader::In {
 public:
  In(std::span<const std::byte> bytes, std::size_t offset) : bytes_(bytes), offset_(offset) {}

  [[noreturn]] void refuse(std::string_view what, std::string_view rule) const {
    throw TraceError(offset_ + at_, what, rule);
  }
  void require(bool holds, std::string_view what, std::string_view rule) const {
    if (!holds) refuse(what, rule);
  }
  std::uint64_t varint(std::string_view what) {
    std::uint64_t value = 0;
    require(read_varint(bytes_, at_, value), what, "a varint of at most 64 bits within the record");
    return value;
  }
  std::uint64_t varint(std::string_view what, std::uint64_t most, std::string_view rule) {
    const std::uint64_t value = varint(what);
    require(value <= most, what, rule);
    return value;
  }
  /// Reads a count of elements, each at least `least` bytes long.
  std::size_t count(std::string_view what, std::size_t least) {
    return static_cast<std::size_t>(
        varint(what, remaining() / least, "no more than fit into the record"));
  }
  std::int64_t signed_varint(std::string_view what) {
    const std::uint64_t bits = varint(what);
    return static_cast<std::int64_t>(bits >> 1 ^ ((bits & 1) != 0 ? ~std::uint64_t{0} : 0));
  }
  std::span<const std::byte> bytes(std::string_view what, std::uint64_t count) {
    require(count <= remaining(), what, "no longer than the record");
    const auto result = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += result.size();
    return result;
  }
  /// @param packet  in: the base
  void decode(std::span<std::byte> packet) {
    require(decode_packet(bytes_, at_, packet), "packet", "runs of its length within the record");
  }
  std::uint8_t u8(std::string_view what, std::uint8_t most, std::string_view rule) {
    const auto value = static_cast<std::uint8_t>(bytes(what, 1)[0]);
    require(value <= most, what, rule);
    return value;
  }
  std::uint32_t u32(std::string_view what) { return pbd::ByteReader(bytes(what, 4)).u32(); }
  std::uint64_t u64(std::string_view what) { return pbd::ByteReader(bytes(what, 8)).u64(); }
  double f64(std::string_view what) { return pbd::ByteReader(bytes(what, 8)).f64(); }
  std::string text(std::string_view what) {
    const auto content = bytes(what, varint(what, kMaxText, "at most 4096 bytes"));
    std::string result;
    for (const std::byte each : content) {
      const auto c = static_cast<char>(each);
      require(c >= ' ' && c <= '~', what, "printable ASCII");
      result.push_back(c);
    }
    return result;
  }
  std::size_t remaining() const { return bytes_.size() - at_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t offset_;
  std::size_t at_ = 0;
};

TraceReader::TraceReader(std::span<const std::byte> bytes)
    : bytes_(bytes), checksum_(pbd::hash_bytes({})) {
  read_header();
}

void TraceReader::read_header() {
  In start(bytes_, 0);
  start.require(bytes_.size() >= kHeaderBytes, "file", "long enough for a trace's header");
  for (const char c : kTraceMagic) {
    if (static_cast<char>(start.bytes("magic", 1)[0]) != c) {
      throw TraceError(0, "magic", kTraceMagic);
    }
  }
  const auto version = static_cast<std::uint8_t>(start.bytes("version", 1)[0]);
  start.require(version == kTraceVersion, "version",
                std::to_string(kTraceVersion) + " for this program, is " + std::to_string(version));
  const std::uint32_t length = start.u32("header");
  start.require(length <= start.remaining(), "header", "no longer than the file");
  In in(bytes_.subspan(kHeaderBytes, length), kHeaderBytes);
  header_.scene = in.text("scene");
  header_.arguments.resize(in.count("arguments", 1));
  for (std::string& argument : header_.arguments) argument = in.text("argument");
  header_.self = in.varint("peer");
  in.require(header_.self != 0, "peer", "not 0");
  header_.number = in.varint("number");
  header_.scene_hash = in.u64("scene hash");
  header_.bodies = static_cast<std::uint32_t>(in.varint("bodies", kMaxBodies, "at most 1000000"));
  header_.build = in.text("build");
  in.require(in.remaining() == 0, "header", "at its end after its last field");
  at_ = kHeaderBytes + length;
  checksum_ = pbd::hash_bytes(bytes_.first(at_), checksum_);
  targets_before_.assign(header_.bodies, 0);
  poses_before_.assign(header_.bodies, 0);
}

bool TraceReader::next(TraceRecord& record) {
  offset_ = at_;
  if (at_ == bytes_.size()) return false;
  if (complete()) throw TraceError(at_, "end", "the last record");
  const auto kind = static_cast<std::uint8_t>(bytes_[at_]);
  const bool known = kind >= static_cast<std::uint8_t>(TraceKind::Packets) &&
                     kind <= static_cast<std::uint8_t>(TraceKind::End);
  if (!known) throw TraceError(at_, "kind", "one that there is, is " + std::to_string(kind));
  std::size_t from = at_ + 1;
  std::uint64_t length = 0;
  if (!read_varint(bytes_, from, length)) {
    // The longest varint has ten bytes.
    if (bytes_.size() - at_ - 1 < 10) return false;
    throw TraceError(at_, "length", "a varint");
  }
  if (length > kMaxRecord) throw TraceError(at_, "length", "at most 1 GiB");
  if (length > bytes_.size() - from) return false;
  In in(bytes_.subspan(from, static_cast<std::size_t>(length)), from);
  record.kind = static_cast<TraceKind>(kind);
  if (begins_phase(record.kind)) phase_bytes_ = 0;
  read(in, record);
  in.require(in.remaining() == 0, "record", "at its end after its last field");
  follow(in, record);
  at_ = from + static_cast<std::size_t>(length);
  checksum_ = pbd::hash_bytes(bytes_.subspan(offset_, at_ - offset_), checksum_);
  return true;
}

void TraceReader::read(In& in, TraceRecord& record) {
  switch (record.kind) {
    case TraceKind::Packets:
      read_packets(in, record);
      return;
    case TraceKind::Peers:
      read_peers(in, record);
      return;
    case TraceKind::Limit:
      record.call = in.varint("call");
      record.delivery = static_cast<consensus::Delivery>(in.u8("delivery", 1, "0 or 1"));
      record.bytes = in.varint("limit", kMaxLimit, "at most 4 GiB");
      in.require(record.bytes >= kMinLimit, "limit", "at least 128 bytes");
      return;
    case TraceKind::Refused:
      record.call = in.varint("call");
      return;
    case TraceKind::User:
      record.user = static_cast<std::uint32_t>(in.varint("user", UINT32_MAX, "at most 32 bits"));
      record.time = read_time(in);
      return;
    case TraceKind::Begin:
    case TraceKind::Step:
    case TraceKind::Finish:
    case TraceKind::Leave:
      record.time = read_time(in);
      return;
    case TraceKind::Inputs:
      read_inputs(in, record);
      return;
    case TraceKind::Solved:
      read_stage(in, record.targets, targets_before_);
      read_stage(in, record.poses, poses_before_);
      return;
    case TraceKind::Sent:
      record.sent = in.u64("sent");
      return;
    case TraceKind::Rules:
      record.arguments.resize(in.count("arguments", 1));
      for (std::string& argument : record.arguments) argument = in.text("argument");
      return;
    case TraceKind::End:
      read_end(in, record);
      return;
  }
}

void TraceReader::read_packets(In& in, TraceRecord& record) {
  record.call = in.varint("call");
  // Frees memory, since a few bytes may encode a large record: it must not accumulate.
  record.packets.clear();
  record.packets.resize(in.count("packets", 3));
  for (consensus::Packet& packet : record.packets) {
    packet.from = in.varint("sender");
    packet.received = INT64_MIN;
    const std::uint8_t flags = in.u8("flags", 2 << kDeniedShift | kDated | kCoded, "0 to 11");
    packet.role = static_cast<consensus::Role>(static_cast<int>(consensus::Role::Share) -
                                               (flags >> kDeniedShift));
    if ((flags & kDated) != 0) {
      packet.received =
          static_cast<SessionTime>(static_cast<std::uint64_t>(in.signed_varint("arrival")) +
                                   static_cast<std::uint64_t>(last_time_));
    }
    const std::uint64_t length =
        in.varint("packet", kMaxPackets - phase_bytes_, "at most 64 MiB in its phase");
    phase_bytes_ += length;
    if ((flags & kCoded) != 0) {
      const auto base = history_.like(packet.from, static_cast<std::size_t>(length));
      in.require(!base.empty(), "packet", "like one that has come");
      packet.bytes.assign(base.begin(), base.end());
      in.decode(packet.bytes);
    } else {
      const auto content = in.bytes("packet", length);
      packet.bytes.assign(content.begin(), content.end());
    }
    history_.remember(packet.from, packet.bytes);
  }
}

void TraceReader::read_peers(In& in, TraceRecord& record) {
  record.call = in.varint("call");
  record.peers.assign(in.count("peers", 13), {});
  consensus::PeerId before = 0;
  for (consensus::PeerStatus& peer : record.peers) {
    peer.id = in.varint("peer");
    in.require(peer.id > before, "peer", "above the one before it");
    before = peer.id;
    peer.connected = in.u8("connected", 1, "0 or 1") != 0;
    peer.kbit_per_s = in.f64("kbit_per_s");
    in.require(peer.kbit_per_s >= 0.0 && peer.kbit_per_s <= 1e12, "kbit_per_s", "from 0 to 1e12");
    peer.round_trip = in.signed_varint("round trip");
    peer.dropped_queue_full = in.varint("dropped");
    peer.rejected = in.varint("rejected");
  }
}

void TraceReader::read_inputs(In& in, TraceRecord& record) {
  record.user = static_cast<std::uint32_t>(in.varint("user", UINT32_MAX, "at most 32 bits"));
  const bool seated = std::find(users_.begin(), users_.end(), record.user) != users_.end();
  in.require(seated, "user", "one who has sat down, is " + std::to_string(record.user));
  record.inputs.resize(in.count("inputs", 3));
  for (Input& input : record.inputs) {
    input.user = record.user;
    input.time = 0;
    constexpr auto kLast = static_cast<std::uint8_t>(Input::Kind::Signal);
    input.kind = static_cast<Input::Kind>(in.u8("input", kLast, "one that there is"));
    input.object = static_cast<std::uint32_t>(in.varint("object", UINT32_MAX, "at most 32 bits"));
    const std::uint64_t bodies = std::max<std::uint32_t>(1, header_.bodies);
    input.body = static_cast<std::uint32_t>(in.varint("body", bodies - 1, "one of the scene's"));
    const bool moves = input.kind == Input::Kind::Drive || input.kind == Input::Kind::Jump;
    in.require(!moves || input.object == input.body, "object", "the body that is moved");
    input.values.resize(value_count(input.kind));
    for (double& value : input.values) value = in.f64("value");
    const std::string_view rule = broken_rule(input);
    in.require(rule.empty(), "values", rule);
  }
}

void TraceReader::read_stage(In& in, StageHash& stage, std::vector<std::uint32_t>& before) {
  stage.all = in.u64("hash");
  const auto mask = in.bytes("changed bodies", (before.size() + 7) / 8);
  const auto changed = [mask](std::size_t i) {
    return (mask[i / 8] >> (i % 8) & std::byte{1}) != std::byte{0};
  };
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (changed(i)) before[i] = in.u32("hash of a body");
  }
  for (std::size_t i = before.size(); i < 8 * mask.size(); ++i) {
    in.require(!changed(i), "changed bodies", "no more than there are");
  }
  stage.bodies = before;
}

void TraceReader::read_end(In& in, TraceRecord& record) {
  record.steps = in.varint("steps");
  in.require(record.steps == steps_, "steps",
             std::to_string(steps_) + ", as many as there are, is " + std::to_string(record.steps));
  in.require(in.u64("checksum") == checksum_, "checksum",
             "that of all before it, is another: the trace is damaged");
}

SessionTime TraceReader::read_time(In& in) {
  const auto step = static_cast<std::uint64_t>(in.signed_varint("time"));
  const auto time = static_cast<SessionTime>(static_cast<std::uint64_t>(last_time_) + step);
  in.require(time > 0 && time < kMaxTime, "time", "above 0 and below 2^62 ns");
  last_time_ = time;
  return time;
}

void TraceReader::follow(In& in, const TraceRecord& record) {
  const bool waiting = state_ == State::Idle || state_ == State::Begun;
  const auto need = [&in](bool holds) { in.require(holds, "record", "in its order"); };
  switch (record.kind) {
    case TraceKind::Packets:
    case TraceKind::Peers:
    case TraceKind::Limit:
    case TraceKind::Refused:
      return;
    case TraceKind::User:
      need(waiting);
      in.require(std::find(users_.begin(), users_.end(), record.user) == users_.end(), "user",
                 "one who has not sat down, is " + std::to_string(record.user));
      in.require(users_.size() < kMaxUsers, "users", "at most 1024");
      users_.push_back(record.user);
      return;
    case TraceKind::Begin:
      need(waiting);
      begun_ = record.time;
      state_ = State::Begun;
      return;
    case TraceKind::Inputs:
      need(state_ == State::Begun);
      return;
    case TraceKind::Step:
      need(state_ == State::Begun);
      in.require(record.time > begun_ && record.time - begun_ <= kMaxStep, "step",
                 "above 0 and at most 10 s long");
      state_ = State::Stepping;
      return;
    case TraceKind::Solved:
      need(state_ == State::Stepping);
      state_ = State::Solved;
      ++steps_;
      return;
    case TraceKind::Finish:
      need(state_ == State::Solved);
      state_ = State::Finished;
      return;
    case TraceKind::Leave:
      need(waiting);
      state_ = State::Finished;
      return;
    case TraceKind::Sent:
      need(state_ == State::Finished);
      state_ = State::Idle;
      return;
    case TraceKind::Rules:
      need(waiting || state_ == State::Solved);
      return;
    case TraceKind::End:
      need(waiting || state_ == State::Solved);
      state_ = State::Ended;
      return;
  }
}

}  // namespace tandem::demos
