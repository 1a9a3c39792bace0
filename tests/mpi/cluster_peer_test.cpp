// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A cluster among people, in virtual time: packets of a step arrive everywhere some steps later.
// The person lives on rank 0, in a world of its own.
#include "tandem/mpi/cluster_peer.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/catch.h"
#include "tandem/collision/contact_source.h"

namespace tandem::mpi {
namespace {

using consensus::PeerId;
using consensus::SessionTime;
using pbd::Vec3;

constexpr double kFrame = 1.0 / 60.0;         // s
constexpr SessionTime kFrameNs = 16'666'667;  // ns
constexpr std::size_t kLatency = 4;           // steps
constexpr PeerId kPerson = 1;                 // ranks are 2, 3, ...

PeerId peer_of(int rank) { return static_cast<PeerId>(rank) + 2; }

/// Packets of one peer, sent and received; carry() takes them from rank to rank.
class Lockstep final : public consensus::Transport {
 public:
  Lockstep(PeerId self, int ranks) : self_(self) {
    for (PeerId id = 1; id < static_cast<PeerId>(ranks) + 2; ++id) {
      if (id != self) others_.push_back({.id = id, .connected = true, .reason = {}});
    }
  }
  PeerId self() const override { return self_; }
  bool post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery) override {
    const std::uint64_t head[] = {self_, to, bytes.size()};
    const auto raw = std::as_bytes(std::span(head));
    out.insert(out.end(), raw.begin(), raw.end());
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
  }
  void drain(std::vector<consensus::Packet>& all) override {
    for (consensus::Packet& packet : in) all.push_back(std::move(packet));
    in.clear();
  }
  void drop(PeerId, const std::string& reason) override { dropped.push_back(reason); }
  std::vector<consensus::PeerStatus> peers() const override { return others_; }

  std::vector<std::byte> out;
  std::vector<consensus::Packet> in;
  std::vector<std::string> dropped;

 private:
  PeerId self_;
  std::vector<consensus::PeerStatus> others_;
};

/// All ranks: what everybody has posted, some steps later, to those it is for.
class Wire {
 public:
  void carry(std::span<Lockstep* const> here) {
    std::vector<std::byte> own;
    for (Lockstep* each : here) {
      own.insert(own.end(), each->out.begin(), each->out.end());
      each->out.clear();
    }
    int count = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    const int size = static_cast<int>(own.size());
    std::vector<int> sizes(static_cast<std::size_t>(count));
    MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    std::vector<int> places(sizes.size(), 0);
    for (std::size_t r = 1; r < sizes.size(); ++r) places[r] = places[r - 1] + sizes[r - 1];
    std::vector<std::byte> all(static_cast<std::size_t>(places.back() + sizes.back()));
    MPI_Allgatherv(own.data(), size, MPI_BYTE, all.data(), sizes.data(), places.data(), MPI_BYTE,
                   MPI_COMM_WORLD);
    on_the_way_.push_back(std::move(all));
    if (on_the_way_.size() <= kLatency) return;
    const std::vector<std::byte> come = std::move(on_the_way_.front());
    on_the_way_.pop_front();
    for (std::size_t at = 0; at < come.size();) {
      std::uint64_t head[3] = {};
      std::memcpy(head, come.data() + at, sizeof head);
      at += sizeof head;
      for (Lockstep* each : here) {
        if (each->self() != head[1]) continue;
        consensus::Packet& packet = each->in.emplace_back();
        packet.from = head[0];
        packet.bytes.assign(come.begin() + static_cast<std::ptrdiff_t>(at),
                            come.begin() + static_cast<std::ptrdiff_t>(at + head[2]));
      }
      at += head[2];
    }
  }

 private:
  std::deque<std::vector<std::byte>> on_the_way_;
};

pbd::BodyDef crate_def(std::uint64_t id, const Vec3& at) {
  const collision::MassProperties mass =
      collision::mass_properties(collision::Box{Vec3::Constant(0.1)}, 100.0);
  pbd::BodyDef def;
  def.mass = mass.mass;
  def.inertia = mass.inertia;
  def.pose.position = at;
  def.stable_id = id;
  return def;
}

collision::ColliderDef box() { return {.shape = collision::Box{Vec3::Constant(0.1)}}; }
collision::ColliderDef ground() { return {.shape = collision::HalfSpace{}}; }

constexpr std::uint64_t kCrates = 12;
Vec3 place_of(std::uint64_t crate) { return {static_cast<double>(crate), 0.0, 0.1}; }
consensus::SharedId name_of(std::uint64_t crate) {
  return consensus::SharedId::from_name("crate " + std::to_string(crate));
}

/// A person with a copy of all crates.
struct Person {
  explicit Person(int ranks) : transport(kPerson, ranks), peer(world, transport) {
    world.set_contact_source(&shapes);
    collision::ColliderDef floor = ground();
    floor.body = world.add_body({.type = pbd::BodyType::Static});
    shapes.add(world, floor);
    for (std::uint64_t i = 0; i < kCrates; ++i) {
      crates.push_back(world.add_body(crate_def(i, place_of(i))));
      collision::ColliderDef collider = box();
      collider.body = crates.back();
      shapes.add(world, collider);
      peer.share({.id = name_of(i), .body = crates.back()});
    }
  }
  pbd::World world;
  collision::CollisionScene shapes;
  pbd::Solver solver;
  Lockstep transport;
  consensus::Peer peer;
  std::vector<pbd::BodyId> crates;
};

TEST_CASE("cluster peer: a person pulls a crate through the parts of a cluster", "[mpi]") {
  ClusterOptions options;
  options.balance_every = 4;
  options.balance_above = 1.0;
  Cluster cluster(options);
  {
    const collision::ColliderDef floor[] = {ground()};
    cluster.add({.type = pbd::BodyType::Static}, floor);
  }
  for (std::uint64_t i = 0; i < kCrates; ++i) {
    if (static_cast<int>(i) % cluster.count() != cluster.rank()) continue;
    const collision::ColliderDef collider[] = {box()};
    cluster.add(crate_def(i, place_of(i)), collider);
  }
  cluster.start();
  Lockstep transport(peer_of(cluster.rank()), cluster.count());
  consensus::Peer peer(cluster.world(), transport);
  ClusterPeer shared(cluster, peer);
  for (std::uint64_t i = 0; i < kCrates; ++i) shared.share(i, name_of(i));

  std::unique_ptr<Person> person;
  if (cluster.rank() == 0) person = std::make_unique<Person>(cluster.count());
  std::vector<Lockstep*> here{&transport};
  if (person != nullptr) here.push_back(&person->transport);
  Wire wire;
  consensus::GrabId hand;
  SessionTime now = 1'000'000'000;
  int owner_changes = 0;
  bool had = cluster.own_body(0).valid();
  for (int k = 0; k < 900; ++k) {
    now = cluster.agree_on(now);
    shared.follow();
    peer.before_step(now);
    cluster.step(kFrame);
    peer.after_step(now + kFrameNs);
    const bool has = cluster.own_body(0).valid();
    owner_changes += has != had ? 1 : 0;
    had = has;
    if (person != nullptr) {
      // Up, over all other crates to their far end, and down.
      const double t = kFrame * k;
      const double along = std::clamp((t - 2.0) / 6.0, 0.0, 1.0);
      const Vec3 target(13.0 * along, 0.0, t < 9.0 ? 0.6 : 0.2);
      if (k == 60) {
        hand = person->peer.grab({.body = name_of(0), .anchor_w = place_of(0), .stiffness = 400.0});
      }
      if (k > 60 && k < 600) person->peer.move(hand, target, now);
      if (k == 600) person->peer.release(hand);
      person->peer.before_step(now);
      person->solver.step(person->world, kFrame);
      person->peer.after_step(now + kFrameNs);
    }
    wire.carry(here);
    now += kFrameNs;
  }
  CHECK(transport.dropped.empty());
  // Where rank 0's person has the crates, everybody has them.
  std::vector<double> places(3 * kCrates, 0.0);
  if (person != nullptr) {
    CHECK(person->transport.dropped.empty());
    for (std::uint64_t i = 0; i < kCrates; ++i) {
      const Vec3 x = person->world.pose(person->crates[i]).position;
      std::copy(x.begin(), x.end(), places.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
    CHECK(places[0] > 11.5);  // it has come there
    CHECK(places[2] < 0.15);  // and lies
  }
  MPI_Bcast(places.data(), static_cast<int>(places.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
  for (std::uint64_t i = 0; i < kCrates; ++i) {
    const pbd::BodyId body = cluster.own_body(i);
    if (!body.valid()) continue;
    const Vec3 there(places[3 * i], places[3 * i + 1], places[3 * i + 2]);
    CAPTURE(i);
    CHECK((cluster.world().pose(body).position - there).norm() < 1e-3);
  }
  // Every body is somebody's, and the crate has been several ranks'.
  int owned = 0;
  for (std::uint64_t i = 0; i < kCrates; ++i) owned += cluster.own_body(i).valid() ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &owned, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  CHECK(owned == static_cast<int>(kCrates));
  MPI_Allreduce(MPI_IN_PLACE, &owner_changes, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
  CHECK((owner_changes > 0) == (cluster.count() > 1));
}

TEST_CASE("cluster peer: sharing twice is refused", "[mpi]") {
  Cluster cluster;
  cluster.start();
  Lockstep transport(peer_of(cluster.rank()), cluster.count());
  consensus::Peer peer(cluster.world(), transport);
  ClusterPeer shared(cluster, peer);
  shared.share(1, name_of(1));
  CHECK_THROWS_WITH(shared.share(1, name_of(2)),
                    Catch::Contains("stable_id") && Catch::Contains("1"));
  CHECK_THROWS_WITH(shared.share(2, name_of(1)), Catch::Contains("ClusterPeer::share: id"));
  CHECK_THROWS_WITH(shared.share(2, {}), Catch::Contains("names something"));
  CHECK_THROWS_WITH(shared.share(std::uint64_t{1} << 63, name_of(3)),
                    Catch::Contains("below 2^63"));
}

}  // namespace
}  // namespace tandem::mpi
