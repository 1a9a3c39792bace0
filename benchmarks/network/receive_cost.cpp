// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// What it takes to hear of a body: to authenticate and decrypt the datagrams, to parse them, to
// predict and to aggregate, all that happens between a socket and the solver. Prints one line of
// CSV for each format and number of bodies:
//
//   format, bodies, bytes for each state, CPU time (us) for each state: open, before_step, collect,
//   all
//
// One peer sends all its bodies each frame, in datagrams of at most 1200 bytes, as over UDP; the
// bodies move on circles at both. Medians over the frames.

#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/measure/clock.h"
#include "packet_protection.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/solver.h"

namespace {

using namespace tandem;
using consensus::Packet;
using consensus::PeerId;
using consensus::SessionTime;

constexpr int kFrames = 240;
constexpr int kWarmUp = 60;               // frames
constexpr SessionTime kFrame = 16666667;  // ns
constexpr SessionTime kDelay = 3 * kFrame;

net::crypto::Secret some_key() {
  std::array<std::uint8_t, 32> bytes{};
  bytes[0] = 7;
  return net::crypto::Secret(bytes);
}

/// What is posted is sealed, and opened again where it is drained. What is reliable (names, once)
/// would be in pieces and is passed on as it is.
class SealedTransport final : public consensus::Transport {
 public:
  SealedTransport(PeerId self, PeerId other)
      : self_(self), other_(other), sealer_(key_, 1, 0), opener_(key_) {}

  PeerId self() const override { return self_; }
  bool post(PeerId, std::span<const std::byte> bytes, consensus::Delivery delivery) override {
    if (delivery == consensus::Delivery::Reliable) {
      reliable.emplace_back(bytes.begin(), bytes.end());
      return true;
    }
    std::vector<std::byte> datagram;
    if (!sealer_.seal(bytes, 0, datagram)) return false;
    posted.push_back(std::move(datagram));
    return true;
  }
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override {
    if (delivery == consensus::Delivery::Reliable) return consensus::kMaxPacketBytes;
    return net::kMaxRelayed - net::kProtectedOverhead;
  }
  void drain(std::vector<Packet>& out) override {
    const double before = bench::thread_seconds();
    for (const std::vector<std::byte>& datagram : arrived) {
      const auto opened = opener_.open(datagram, buffer_);
      if (!opened) continue;
      out.push_back({other_, {opened->plain.begin(), opened->plain.end()}});
    }
    open_s += bench::thread_seconds() - before;
    arrived.clear();
    for (std::vector<std::byte>& bytes : arrived_reliable)
      out.push_back({other_, std::move(bytes)});
    arrived_reliable.clear();
  }
  void drop(PeerId, const std::string&) override {}
  std::vector<consensus::PeerStatus> peers() const override {
    return {{.id = other_, .connected = true}};
  }

  std::vector<std::vector<std::byte>> posted;
  std::vector<std::vector<std::byte>> arrived;
  std::vector<std::vector<std::byte>> reliable;  ///< posted
  std::vector<std::vector<std::byte>> arrived_reliable;
  double open_s = 0.0;  ///< CPU time

 private:
  PeerId self_;
  PeerId other_;
  net::crypto::Secret key_ = some_key();
  net::PacketSealer sealer_;
  net::PacketOpener opener_;
  std::vector<std::byte> buffer_;
};

/// A world with bodies on circles, and what shares them.
class Site {
 public:
  Site(PeerId self, PeerId other, std::size_t bodies, const consensus::PeerOptions& options)
      : transport(self, other), peer(world, transport, options) {
    for (std::size_t i = 0; i < bodies; ++i) {
      ids_.push_back(world.add_body({.pose = pose(i, 0), .mass = 1.0}));
      peer.share({.id = {1, i + 1}, .body = ids_.back()});
    }
  }
  void move_to(SessionTime now) {
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      world.set_pose(ids_[i], pose(i, now));
      world.set_twist(ids_[i], {.linear = velocity(i, now), .angular = pbd::Vec3(0.0, 0.0, kTurn)});
    }
  }

  pbd::World world;
  SealedTransport transport;
  consensus::Peer peer;

 private:
  static constexpr double kTurn = 2.0;    // rad/s
  static constexpr double kRadius = 0.3;  // m

  static double angle(std::size_t i, SessionTime now) {
    return static_cast<double>(i) + kTurn * 1e-9 * static_cast<double>(now);
  }
  static pbd::Pose pose(std::size_t i, SessionTime now) {
    const double a = angle(i, now);
    const auto row = static_cast<double>(i / 30), column = static_cast<double>(i % 30);
    return {pbd::Vec3(0.2 * row + kRadius * std::cos(a), 0.2 * column + kRadius * std::sin(a), 1.0),
            pbd::Quat(std::cos(0.5 * a), 0.0, 0.0, std::sin(0.5 * a))};
  }
  static pbd::Vec3 velocity(std::size_t i, SessionTime now) {
    const double a = angle(i, now);
    return kRadius * kTurn * pbd::Vec3(-std::sin(a), std::cos(a), 0.0);
  }
  std::vector<pbd::BodyId> ids_;
};

void run(const char* format, std::size_t bodies, const consensus::PeerOptions& options) {
  Site sender(2, 1, bodies, options);
  Site receiver(1, 2, bodies, options);
  std::deque<std::vector<std::vector<std::byte>>> on_the_way;
  std::vector<double> open, before_step, collect, all;
  std::vector<pbd::PoseTarget> targets;
  std::size_t bytes = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const SessionTime now = (frame + 1) * kFrame;
    sender.move_to(now);
    sender.peer.before_step(now);
    sender.peer.after_step(now);
    if (frame == kFrames - 1) {
      for (const auto& datagram : sender.transport.posted) bytes += datagram.size();
    }
    on_the_way.push_back(std::exchange(sender.transport.posted, {}));
    sender.transport.arrived = std::exchange(receiver.transport.posted, {});
    sender.transport.arrived_reliable = std::exchange(receiver.transport.reliable, {});
    receiver.transport.arrived_reliable = std::exchange(sender.transport.reliable, {});
    if (on_the_way.size() > static_cast<std::size_t>(kDelay / kFrame)) {
      receiver.transport.arrived = std::move(on_the_way.front());
      on_the_way.pop_front();
    }
    receiver.move_to(now);
    const std::uint64_t heard = receiver.peer.stats().updates_received;
    receiver.transport.open_s = 0.0;
    targets.clear();
    const double start = bench::thread_seconds();
    receiver.peer.before_step(now);
    const double middle = bench::thread_seconds();
    receiver.peer.collect(receiver.world, 1e-9 * static_cast<double>(kFrame), {}, targets);
    const double end = bench::thread_seconds();
    receiver.peer.after_step(now);
    const auto states = static_cast<double>(receiver.peer.stats().updates_received - heard);
    if (frame < kWarmUp || states == 0.0 || targets.empty()) continue;
    open.push_back(1e6 * receiver.transport.open_s / states);
    before_step.push_back(1e6 * (middle - start) / states - open.back());
    collect.push_back(1e6 * (end - middle) / states);
    all.push_back(1e6 * (end - start) / states);
  }
  std::printf("%s,%zu,%.1f,%.3f,%.3f,%.3f,%.3f\n", format, bodies,
              static_cast<double>(bytes) / static_cast<double>(bodies), bench::quantile(open, 0.5),
              bench::quantile(before_step, 0.5), bench::quantile(collect, 0.5),
              bench::quantile(all, 0.5));
}

}  // namespace

int main() {
  std::puts("format,bodies,bytes_per_state,open_us,before_step_us,collect_us,all_us");
  // A replay costs what its steps cost, and is begun only where peers differ: not measured here.
  consensus::PeerOptions full;
  full.predictor = consensus::PredictorKind::Euler;
  consensus::PeerOptions compact = full;
  compact.sending.format = consensus::StateFormat::Compact;
  for (const std::size_t bodies : {30u, 300u, 900u}) {
    run("full", bodies, full);
    run("compact", bodies, compact);
  }
  return 0;
}
