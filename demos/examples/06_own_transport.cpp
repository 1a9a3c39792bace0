// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A custom transport: here a queue with a fixed delay, in practice Steam, WebRTC or a game server.
// It carries bytes, may lose states, never blocks, and knows who is connected.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/peer.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/solver.h"

using namespace tandem;

/// Two peers, 1 and 2. A packet arrives three steps after posting. One state in five is lost,
/// reliable packets never are.
class Mailbox final : public consensus::Transport {
 public:
  Mailbox(consensus::PeerId self, Mailbox* other) : self_(self), other_(other) {
    if (other_ != nullptr) other_->other_ = this;
  }
  void tick() { ++time_; }

  consensus::PeerId self() const override { return self_; }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    if (to == self_ || dropped_) return false;
    ++posted;
    if (delivery == consensus::Delivery::Newest && posted % 5 == 0) return true;  // lost
    other_->waiting_.push_back({time_ + 3, {self_, {bytes.begin(), bytes.end()}}});
    return true;
  }
  void drain(std::vector<consensus::Packet>& out) override {
    while (!waiting_.empty() && waiting_.front().due <= time_) {
      out.push_back(std::move(waiting_.front().packet));
      waiting_.erase(waiting_.begin());
      ++delivered;
    }
  }
  void drop(consensus::PeerId /*peer*/, const std::string& reason) override {
    dropped_ = true;
    why_ = reason;
  }
  std::vector<consensus::PeerStatus> peers() const override {
    return {{.id = other_->self_, .connected = !dropped_, .reason = why_}};
  }

  int posted = 0;
  int delivered = 0;

 private:
  struct Waiting {
    int due = 0;
    consensus::Packet packet;
  };
  consensus::PeerId self_;
  Mailbox* other_;
  int time_ = 0;  // steps
  bool dropped_ = false;
  std::string why_;
  std::vector<Waiting> waiting_;
};

int main() {
  Mailbox first(1, nullptr);
  Mailbox second(2, &first);
  pbd::World worlds[2] = {pbd::World({.gravity = pbd::Vec3::Zero()}),
                          pbd::World({.gravity = pbd::Vec3::Zero()})};
  consensus::Peer peers[2] = {{worlds[0], first}, {worlds[1], second}};
  pbd::Solver solver;  // keeps nothing between steps: one serves both worlds
  pbd::BodyId bodies[2];
  for (int k = 0; k < 2; ++k) {
    bodies[k] = worlds[k].add_body({.pose = {.position = pbd::Vec3(0.3 * k, 0.0, 0.0)}});
    peers[k].share({.id = consensus::SharedId::from_name("cube"), .body = bodies[k]});
  }

  constexpr consensus::SessionTime kStep = 16'666'667;  // ns
  for (consensus::SessionTime i = 0, now = 1'000'000'000; i < 600; ++i, now += kStep) {
    for (int k = 0; k < 2; ++k) {
      peers[k].before_step(now);
      solver.step(worlds[k], 1e-9 * static_cast<double>(kStep));
      peers[k].after_step(now + kStep);
    }
    first.tick();
    second.tick();
  }
  const double apart =
      (worlds[0].pose(bodies[0]).position - worlds[1].pose(bodies[1]).position).norm();
  const auto rejected = peers[0].stats().packets_rejected + peers[1].stats().packets_rejected;
  std::printf("posted %d, delivered %d, refused %d; copies apart by %.2g m\n", first.posted,
              second.delivered, static_cast<int>(rejected), apart);
  const bool lost = second.delivered < first.posted && second.delivered > first.posted / 2;
  return apart < 1e-3 && rejected == 0 && lost ? 0 : 1;
}
