// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/shared_id.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// Properties of the sender's instance at the stamp; predictors choose by them.
struct TANDEM_API UpdateFlags {
  bool in_contact = false;    ///< touches or is joined to something
  bool held = false;          ///< pulled by a user's spring
  bool owner_driven = false;  ///< moved by hand, whatever the forces are
  bool teleported = false;    ///< jumped since the last update: the jump is not motion
  /// The sender leads: its user was the last and only one to act on the body, and it ignores
  /// others.
  bool leads = false;
  /// At rest, until the sender says otherwise: see SendOptions.
  bool resting = false;

  friend bool operator==(const UpdateFlags&, const UpdateFlags&) = default;
};

/// A peer's estimate of one shared body after its step, [friston] Table 2.
/// On the wire: position 64-bit floats, velocities and influence 32-bit floats, orientation four
/// 32-bit fixed-point numbers (2^-30, so turned by less than 2e-9 rad by the rounding).
struct TANDEM_API StateUpdate {
  SharedId id = {};
  pbd::Pose pose = {};     ///< of the centre of mass, world
  pbd::Twist twist = {};   ///< world
  float influence = 0.0f;  ///< share per 1/60 s of session time, 0 to 1; 1 = the sender owns it
  SessionTime stamp = 0;   ///< ns, session time of the state
  UpdateFlags flags = {};
  /// Decoded from the compact format: within half a quantum of the sender's state. Not sent.
  bool rounded = false;
  /// Whether the orientation is sent, see ShareDef::orientation. The full format always has it.
  bool oriented = true;
};

enum class SpringEvent : std::uint8_t { Create = 1, Change = 2, Remove = 3 };

/// A user's spring between a moving point of the world and a point of a shared body; every peer
/// simulates it. All numbers are 64-bit floats on the wire, so that all peers simulate the same
/// spring.
struct TANDEM_API SpringUpdate {
  std::uint32_t spring = 0;    ///< unique per sender
  std::uint32_t revision = 0;  ///< grows with each event of this spring
  SpringEvent event = SpringEvent::Create;
  SharedId body = {};
  pbd::Vec3 attachment_l = pbd::Vec3::Zero();     ///< m, frame of the body
  pbd::Vec3 anchor_w = pbd::Vec3::Zero();         ///< m, world, at the stamp
  pbd::Vec3 anchor_velocity = pbd::Vec3::Zero();  ///< m/s, world, at the stamp
  double stiffness = 0.0;                         ///< N/m
  double damping = 0.0;                           ///< N s/m
  double max_force = 0.0;                         ///< N
  SessionTime stamp = 0;                          ///< ns, session time of the anchor
};

enum class OwnershipEvent : std::uint8_t { Request = 1, Grant = 2 };

/// Ownership messages between peers of Coupling::SingleOwner.
struct TANDEM_API OwnershipUpdate {
  SharedId body = {};
  PeerId to = 0;  ///< the peer asked for ownership, or granted it; never 0
  OwnershipEvent event = OwnershipEvent::Request;
  SessionTime stamp = 0;  ///< ns: when the sender's user began to act, or when it was granted
};

/// The sender is about to leave the session: its states and springs end here.
struct TANDEM_API Leave {
  SessionTime stamp = 0;  ///< ns
};

/// A state whose body is named by the sender's index, see compact.h; update.id is all zeros.
struct TANDEM_API CompactState {
  std::uint32_t table = 0;  ///< the sender's list of indices
  std::uint16_t index = 0;
  StateUpdate update = {};
};

/// The sender's index of a body. Within one table an index never changes its meaning.
struct TANDEM_API IndexAssignment {
  std::uint32_t table = 0;
  std::uint16_t index = 0;
  SharedId id = {};
};

/// The sender lacks the ids of indices, or the states of resting bodies, and asks for all of them
/// again.
struct TANDEM_API IndicesWanted {
  std::uint32_t table = 0;  ///< of those states
};

/// The anchor of a spring that was sent in full before, see SpringUpdate.
struct TANDEM_API AnchorUpdate {
  std::uint32_t spring = 0;
  pbd::Vec3 anchor_w = pbd::Vec3::Zero();         ///< m, world, at the stamp
  pbd::Vec3 anchor_velocity = pbd::Vec3::Zero();  ///< m/s, world, at the stamp
  SessionTime stamp = 0;                          ///< ns
};

/// The sender is present: its states of resting bodies still hold.
struct TANDEM_API Alive {
  SessionTime stamp = 0;  ///< ns
};

/// An instantaneous act of the sender's application on a shared body, see Peer::act(). Pose and
/// twist are set first, then the impulses are added. Numbers are 64-bit floats on the wire; the
/// orientation is encoded as in a StateUpdate.
struct TANDEM_API ActUpdate {
  std::uint32_t number = 0;  ///< of the sender's acts
  SharedId body = {};
  std::uint64_t name = 0;                         ///< see ActDef::name
  pbd::Vec3 impulse = pbd::Vec3::Zero();          ///< N s, world, at the centre of mass
  pbd::Vec3 angular_impulse = pbd::Vec3::Zero();  ///< N m s, world
  std::optional<pbd::Pose> pose = {};             ///< of the centre of mass, world, at the stamp
  std::optional<pbd::Twist> twist = {};           ///< world, at the stamp
  SessionTime stamp = 0;                          ///< ns
};

/// The sender has done an act, its own or another's, at the stamp: its later states include it.
struct TANDEM_API ActReceipt {
  PeerId actor = 0;
  std::uint32_t number = 0;  ///< of the actor's acts
  SharedId body = {};
  std::uint64_t name = 0;  ///< of the act; if not 0, actor and number are ignored
  SessionTime stamp = 0;   ///< ns
};

/// All records of one packet. Reuse it: decode() keeps the capacities.
struct TANDEM_API DecodedPacket {
  std::vector<StateUpdate> states = {};
  std::vector<SpringUpdate> springs = {};
  std::vector<Leave> leaves = {};
  std::vector<OwnershipUpdate> ownership = {};
  std::vector<CompactState> compact = {};
  std::vector<IndexAssignment> assignments = {};
  std::vector<IndicesWanted> indices_wanted = {};
  std::vector<Alive> alive = {};
  std::vector<AnchorUpdate> anchors = {};
  std::vector<ActUpdate> acts = {};
  std::vector<ActReceipt> receipts = {};

  void clear();
};

enum class PacketFault : std::uint8_t {
  None,
  TooLong,    ///< longer than kMaxPacketBytes
  BadLength,  ///< empty, or ends within a message
  BadMagic,
  BadVersion,
  UnknownKind,
  BadCount,  ///< no records, or more than kMaxRecords
  BadId,     ///< all zeros
  BadCode,   ///< bits or codes unknown to this version
  NotFinite,
  OutOfRange,
};

/// Whether a packet or a record is acceptable, and if not, why.
struct [[nodiscard]] TANDEM_API CodecResult {
  PacketFault fault = PacketFault::None;
  const char* detail = "";  ///< field and rule; a static string
  std::size_t offset = 0;   ///< bytes before the faulty message or record

  bool ok() const { return fault == PacketFault::None; }
  /// "byte 106: orientation: norm must be within 1e-3 of 1"; "" where ok.
  std::string reason() const;
};

inline constexpr std::uint16_t kPacketMagic = 0x4354;  ///< "TC" on the wire
inline constexpr std::uint8_t kPacketVersion = 2;
inline constexpr std::size_t kMaxRecords = 1024;  ///< of one message
inline constexpr std::size_t kHeaderBytes = 6;    ///< magic u16, version u8, kind u8, count u16
inline constexpr std::size_t kStateBytes = 93;
inline constexpr std::size_t kSpringBytes = 129;
inline constexpr std::size_t kLeaveBytes = 8;
inline constexpr std::size_t kOwnershipBytes = 33;
inline constexpr std::size_t kActBytes = 173;
inline constexpr std::size_t kActReceiptBytes = 44;
/// Records of `record_bytes` that fit into a packet with one message; at least one, however short
/// the packet.
constexpr std::size_t records_in(std::size_t packet_bytes, std::size_t record_bytes) {
  const std::size_t room = packet_bytes > kHeaderBytes ? packet_bytes - kHeaderBytes : 0;
  return room < record_bytes ? 1 : room / record_bytes;
}
inline constexpr std::size_t kMaxStatesPerPacket = records_in(kMaxPacketBytes, kStateBytes);
inline constexpr std::size_t kMaxSpringsPerPacket = records_in(kMaxPacketBytes, kSpringBytes);

// Values outside of these ranges are refused as a fault or an attack.
inline constexpr double kMaxPosition = 1e7;          ///< m, norm, exclusive
inline constexpr double kMaxLinearSpeed = 1e5;       ///< m/s, norm, exclusive, in 32 bits
inline constexpr double kMaxAngularSpeed = 1e5;      ///< rad/s, norm, exclusive, in 32 bits
inline constexpr double kMaxSpringParameter = 1e12;  ///< N/m, N s/m, N; exclusive
inline constexpr double kMaxImpulse = 1e12;          ///< N s, N m s; norm, exclusive
/// ns: differences of two stamps within this range do not overflow. About 146 years.
inline constexpr SessionTime kMaxStamp = SessionTime{1} << 62;

/// Whether a peer would accept this record: the test that decode() makes.
TANDEM_API CodecResult check(const StateUpdate& update);
TANDEM_API CodecResult check(const SpringUpdate& update);
TANDEM_API CodecResult check(const Leave& leave);
TANDEM_API CodecResult check(const OwnershipUpdate& update);
TANDEM_API CodecResult check(const Alive& alive);
TANDEM_API CodecResult check(const ActUpdate& act);
TANDEM_API CodecResult check(const ActReceipt& receipt);

/// Append these records to a packet as one message, or several above kMaxRecords. Records that
/// check() refuses are left out: one bad record must not make peers refuse the packet. Mind
/// kMaxPacketBytes. Does not allocate once `out` is large enough.
/// @return records appended
TANDEM_API std::size_t encode(std::span<const StateUpdate> updates, std::vector<std::byte>& out);
TANDEM_API std::size_t encode(std::span<const SpringUpdate> updates, std::vector<std::byte>& out);
TANDEM_API std::size_t encode(const Leave& leave, std::vector<std::byte>& out);
TANDEM_API std::size_t encode(std::span<const OwnershipUpdate> updates,
                              std::vector<std::byte>& out);
TANDEM_API std::size_t encode(std::span<const ActUpdate> acts, std::vector<std::byte>& out);
TANDEM_API std::size_t encode(std::span<const ActReceipt> receipts, std::vector<std::byte>& out);

/// Read a whole packet: one or more messages back to back. All or nothing: on a fault `out` is
/// empty. Orientations are normalised. Never throws because of the bytes; does not allocate once
/// `out` has held as many records.
TANDEM_API CodecResult decode(std::span<const std::byte> packet, DecodedPacket& out);

}  // namespace tandem::consensus
