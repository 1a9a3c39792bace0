// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "plaza/visitor.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "tandem/consensus/update.h"

namespace tandem::demos {

namespace {

constexpr double kArm = 2.5;              // m
constexpr double kLetGo = 1.0;            // m: a body farther from the hand is lost
constexpr std::uint64_t kPlaceEvery = 6;  // steps
constexpr std::uint64_t kSayEvery = 10;   // steps between summaries
constexpr std::size_t kFarBodies = 4;     // per summary

/// A grip that sags by 1 cm under the body's weight, with four times the necessary force.
consensus::GrabDef grip_of(const consensus::SharedId& id, const pbd::Vec3& hand) {
  constexpr double kWeight = 9.81 * PlazaBody::kMass;
  const double stiffness = kWeight / 0.01;
  return {.body = id,
          .anchor_w = hand,
          .stiffness = stiffness,
          .damping = 1.4 * std::sqrt(stiffness * PlazaBody::kMass),
          .max_force = 4.0 * kWeight};
}

nats::NatsOptions nats_options(const PlazaOptions& options, consensus::PeerId id,
                               const VisitorLink& link) {
  nats::NatsOptions out;
  out.hub = link.hub;
  out.member.self = id;
  out.member.scene_hash = options.scene_hash();
  out.member.session_key = plaza_key();
  out.member.kbit_per_s = 2000.0;
  out.member.idle_timeout = std::chrono::milliseconds(15000);
  // The square's time stands still at the end.
  out.member.flush_timeout = std::chrono::milliseconds(0);
  out.cells = options.cells();
  out.direct_peers = options.direct;
  out.steady = link.clock;
  return out;
}

net::UdpOptions udp_options(const PlazaOptions& options, consensus::PeerId id,
                            const VisitorLink& link) {
  net::UdpOptions out;
  out.self = id;
  out.listen_address = "127.0.0.1";
  out.scene_hash = options.scene_hash();
  out.session_key = plaza_key();
  out.kbit_per_s = 2000.0;
  if (link.meet) out.connect = {{"127.0.0.1", *link.meet}};
  return out;
}

}  // namespace

net::Key plaza_key() {
  net::Key key{};
  constexpr std::string_view kText = "tandem plaza, not a secret";
  std::ranges::copy(kText, key.begin());
  return key;
}

Visitor::Visitor(const PlazaOptions& options, std::size_t number, const VisitorLink& link)
    : options_(options), id_(number + 1), hub_(link.hub), walker_(options, number) {
  scene_.add(HalfSpace{}, {.type = BodyType::Static});
  if (link.hub != nullptr) {
    nats_ = std::make_unique<nats::NatsTransport>(nats_options(options, id_, link));
    nats_->set_position(feet());
  } else {
    udp_ = std::make_unique<net::UdpTransport>(udp_options(options, id_, link));
  }
  peer_ = std::make_unique<consensus::Peer>(scene_.world(), wire(), options.peer());
  interest_ = std::make_unique<consensus::NearbyInterest>(
      scene_.world(), *peer_,
      consensus::NearbyInterestOptions{.radius = options.reach() + 2.0 * options.slack(),
                                       .slack = options.slack()});
  if (link.hub != nullptr) {
    ledger_ =
        std::make_unique<nats::BodyLedger>(nats::LedgerOptions{.hub = link.hub,
                                                               .scene_hash = options.scene_hash(),
                                                               .session_key = plaza_key(),
                                                               .cells = options.cells()});
    custody_.emplace(options, id_, scene_, *peer_, *ledger_);
    return;
  }
  for (std::size_t i = 0; i < options.bodies; ++i) {
    const pbd::BodyId body =
        scene_.add(PlazaBody::shape(i), {.mass = PlazaBody::kMass,
                                         .pose = {.position = start_of_body(options, i)},
                                         .linear_damping = 0.1,
                                         .angular_damping = 1.0,
                                         .stable_id = i + 1});
    peer_->share({.id = PlazaBody::id(i), .body = body});
    all_[PlazaBody::id(i)] = body;
  }
}

Visitor::~Visitor() = default;

bool Visitor::is_connected(consensus::PeerId peer) const {
  return std::ranges::find(near_, peer) != near_.end();
}

const pbd::BodyState* Visitor::copy_of(const consensus::SharedId& id) const {
  const pbd::BodyId body = peer_->body_of(id);
  return scene_.world().contains(body) ? &scene_.world().state(body) : nullptr;
}

void Visitor::look_about() {
  const std::vector<consensus::PeerId> before = std::exchange(near_, {});
  wire().list_peers(peers_);
  for (const consensus::PeerStatus& peer : peers_) {
    if (peer.connected) near_.push_back(peer.id);
  }
  for (const consensus::PeerId peer : before) {
    if (!is_connected(peer)) interest_->forget(peer);
  }
  if (nats_ == nullptr) return;
  nats_->set_position(feet());
  // Each visitor announces its position twice a second.
  if (steps_ % kPlaceEvery == 0) {
    served_ = hub_->status().connected;
    near_peers_.clear();
    nats_->near_peers(near_peers_);
    for (const nats::NearPeer& each : near_peers_) {
      interest_->set_position(each.peer, each.position);
    }
  }
  summaries_.clear();
  nats_->take_summaries(summaries_);
  for (const nats::CellSummary& summary : summaries_) {
    ++far_.summaries;
    far_.bytes += summary.content.size();
    if (summary.cell.level == options_.cells().levels - 1) {
      far_.people = std::max(far_.people, summary.people);
    }
  }
}

void Visitor::take_something() {
  const pbd::Vec3 feet = walker_.feet();
  double nearest = kArm;
  std::optional<consensus::SharedId> found;
  const auto look = [&](const consensus::SharedId& id, pbd::BodyId body) {
    const double apart = (scene_.world().pose(body).position - feet).norm();
    if (apart >= nearest || peer_->held(id)) return;
    nearest = apart;
    found = id;
  };
  if (custody_) {
    for (const auto& [id, local] : custody_->local()) look(id, local.body);
  }
  for (const auto& [id, body] : all_) look(id, body);
  if (!found) {
    walker_.lose();
    return;
  }
  const pbd::Vec3 at = scene_.world().pose(peer_->body_of(*found)).position;
  walker_.take(at);
  grab_ = peer_->grab(grip_of(*found, at));
  held_ = found;
}

void Visitor::act(double dt, consensus::SessionTime now) {
  const HandWish wish = walker_.step(dt);
  const auto let_go = [&] {
    if (held_ && peer_->body_of(*held_).valid()) peer_->release(grab_);
    held_.reset();
  };
  switch (wish.kind) {
    case HandWish::Kind::Nothing:
      break;
    case HandWish::Kind::Look:
      take_something();
      break;
    case HandWish::Kind::Hold: {
      const pbd::BodyState* const body = held_ ? copy_of(*held_) : nullptr;
      if (body == nullptr || (body->pose.position - wish.hand).norm() > kLetGo) {
        let_go();
        walker_.lose();
      } else {
        peer_->move(grab_, wish.hand, now);
      }
      break;
    }
    case HandWish::Kind::LetGo:
      let_go();
      break;
  }
}

void Visitor::say_far() {
  for (int level = 1; level < options_.cells().levels; ++level) {
    if (!nats_->speaks(level)) continue;
    // Held or moving bodies first, then resting ones.
    std::vector<consensus::StateUpdate> states;
    for (const auto& [id, local] : custody_->local()) {
      if (states.size() >= kFarBodies) break;
      if (local.still_since != 0) continue;
      if (const auto fused = peer_->fused(id)) states.push_back(*fused);
    }
    std::vector<std::byte> content;
    consensus::encode(states, content);
    nats_->set_summary(level, content);
  }
}

void Visitor::step(consensus::SessionTime now, consensus::SessionTime end) {
  const double dt = net::seconds(end - now);
  look_about();
  if (custody_) custody_->begin(feet(), near_, served_, now);
  act(dt, now);
  peer_->before_step(now);
  scene_.step(dt);
  interest_->update();
  peer_->after_step(end);
  if (custody_) custody_->finish(feet(), held_ ? &*held_ : nullptr, end);
  if (nats_ == nullptr) return;
  if (options_.tells_far && (steps_ + id_) % kSayEvery == 0) say_far();
  nats_->poll();
  ++steps_;
}

void Visitor::leave(consensus::SessionTime now) {
  if (custody_) custody_->leave();
  peer_->leave(now);
}

}  // namespace tandem::demos
