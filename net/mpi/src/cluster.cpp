// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mpi/cluster.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "cluster_impl.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"

namespace tandem::mpi {

using pbd::detail::require;

void ClusterOptions::validate() const {
  require(balance_every >= 1, "ClusterOptions", "balance_every", balance_every, "at least 1");
  require(refresh_every >= 1 && refresh_every <= 1000, "ClusterOptions", "refresh_every",
          refresh_every, "from 1 to 1000");
  require(balance_above >= 1.0 && std::isfinite(balance_above), "ClusterOptions", "balance_above",
          balance_above, "finite and at least 1");
  require(cut_above >= 0.0 && cut_above <= 1.0, "ClusterOptions", "cut_above", cut_above,
          "from 0 to 1");
  require(network.latency >= 0.0 && std::isfinite(network.latency), "NetworkModel", "latency",
          network.latency, "finite and >= 0 s");
  require(network.bandwidth > 0.0, "NetworkModel", "bandwidth", network.bandwidth, "above 0 B/s");
  require(network.overhead >= 0.0 && std::isfinite(network.overhead), "NetworkModel", "overhead",
          network.overhead, "finite and >= 0 s");
}

namespace {

/// Budgets of one rank: those of the options are for the whole world.
pbd::SolverOptions share_of(pbd::SolverOptions options, int ranks) {
  options.contact.extra_rows /= ranks;
  return options;
}

}  // namespace

Cluster::Impl::Impl(const ClusterOptions& options)
    : options_(options),
      world_({.gravity = options.gravity}),
      shapes_(options.collision),
      ranks_(options.network, options.record, options.replay),
      solver_(share_of(options.solver, ranks_.count())),
      part_(world_, shapes_),
      neighbours_(part_, ranks_, options.refresh_every),
      agreement_(part_, ranks_, neighbours_) {
  if (ranks_.count() == 1) {
    world_.set_contact_source(&shapes_);
    return;
  }
  seam_ = &world_.add_block<Seam>(world_, ranks_, neighbours_);
  contacts_ = std::make_unique<PartContacts>(part_, shapes_, *seam_, solver_.options().contact);
  world_.set_contact_source(contacts_.get());
  world_.set_island_coupling(&agreement_);
  balance_ = std::make_unique<Balance>(part_, ranks_, agreement_, options.cut_above);
}

pbd::BodyId Cluster::Impl::add(const pbd::BodyDef& def,
                               std::span<const collision::ColliderDef> colliders) {
  if (started_ && def.type != pbd::BodyType::Dynamic) {
    throw std::invalid_argument("Cluster::add: what does not move must be added before start()");
  }
  const pbd::BodyId body = part_.add(def, colliders);
  if (started_) neighbours_.expect_new();
  return body;
}

void Cluster::Impl::use(const collision::Hull& hull) {
  if (hull == nullptr) throw std::invalid_argument("Cluster::use: hull must be one, is null");
  if (started_) throw std::invalid_argument("Cluster::use: hulls must be named before start()");
  part_.use(hull);
}

void Cluster::Impl::start() {
  if (started_) throw std::invalid_argument("Cluster::start: must be called once");
  started_ = true;
  if (balance_ != nullptr) share_out();
}

const pbd::StepReport& Cluster::Impl::step(double dt) {
  if (!started_) throw std::invalid_argument("Cluster::step: must be called after start()");
  ranks_.begin_step();
  if (balance_ != nullptr) arrange(dt);
  const pbd::StepReport& report = solver_.step(world_, dt);
  ++steps_;
  cost_ = ranks_.end_step();
  state_.own = part_.own().size();
  if (balance_ != nullptr) {
    state_.copies = neighbours_.copy_count();
    state_.seam_rows = contacts_->seam_rows();
    state_.cut_islands = agreement_.own_cut_count();
  }
  return report;
}

/// Work before a step on several ranks.
void Cluster::Impl::arrange(double dt) {
  const auto every = static_cast<std::uint64_t>(options_.balance_every);
  if (steps_ > 0 && steps_ % every == 0 && needs_balance()) share_out();
  const auto news = agreement_.news();
  const bool outdated =
      std::any_of(news.begin(), news.end(), [](const RankNews& n) { return n.outdated; });
  if (steps_ >= refresh_at_ || outdated) {
    neighbours_.refresh(dt, contacts_->carried());
    refresh_at_ = steps_ + static_cast<std::uint64_t>(options_.refresh_every);
  }
  neighbours_.update();
  if ((steps_ + 1) % every == 0) {
    agreement_.set_news(load_.count(part_, seam_->rows(), options_.solver.substeps));
  }
}

bool Cluster::Impl::needs_balance() {
  double most = 0.0;
  double sum = 0.0;
  for (const RankNews& news : agreement_.news()) {
    most = std::max(most, news.load);
    sum += news.load;
  }
  const double mean = sum / ranks_.count();
  state_.imbalance = mean > 0.0 ? most / mean : 1.0;
  return state_.imbalance > options_.balance_above || balance_->has_scattered(mean);
}

/// Decide each body's owner anew, and migrate bodies.
void Cluster::Impl::share_out() {
  load_.count(part_, seam_->rows(), options_.solver.substeps);
  const auto moves = balance_->decide(load_);
  std::vector<std::uint8_t> goes(world_.slot_count(), 0);
  for (const auto& [slot, to] : moves) goes[slot] = 1;
  std::vector<NamedContact>& carried = contacts_->carried();
  for (const pbd::Contact& contact : seam_->rows().contacts()) {
    carried.push_back(part_.named(contact));
  }
  for (const pbd::Contact& contact : world_.contacts()->contacts()) {
    const pbd::Manifold& m = contact.manifold;
    if (goes[m.body_a] != 0 || goes[m.body_b] != 0) carried.push_back(part_.named(contact));
  }
  // All copies are dropped, which must not wake anything.
  const std::vector<pbd::BodyActivity> before(world_.activities().begin(),
                                              world_.activities().end());
  seam_->forget();
  neighbours_.clear();
  migrate(moves);
  for (const std::uint32_t slot : part_.own()) {
    if (slot >= before.size() || arrived_[slot] != 0) continue;
    const pbd::BodyActivity& now = world_.activities()[slot];
    const bool woken =
        now.asleep != before[slot].asleep || now.low_speed_time != before[slot].low_speed_time;
    if (woken) world_.resume(world_.body_at(slot), world_.states()[slot], before[slot]);
  }
  state_.migrated += moves.size();
  ++state_.balanced;
  refresh_at_ = steps_;
}

void Cluster::Impl::migrate(const std::vector<std::pair<std::uint32_t, int>>& moves) {
  const auto count = static_cast<std::size_t>(ranks_.count());
  std::vector<Bytes> out(count);
  std::vector<std::uint64_t> bodies(count, 0);
  std::vector<int> to(world_.slot_count(), ranks_.rank());
  for (const auto& [slot, rank] : moves) {
    to[slot] = rank;
    ++bodies[static_cast<std::size_t>(rank)];
  }
  for (std::size_t r = 0; r < count; ++r) {
    if (bodies[r] > 0) MessageWriter(out[r]).put(bodies[r]);
  }
  for (const auto& [slot, rank] : moves) part_.write(slot, out[static_cast<std::size_t>(rank)]);
  // A contact's warm start data goes with both of its bodies.
  for (const NamedContact& contact : contacts_->carried()) {
    int sent = ranks_.rank();
    for (const BodyName name : {contact.a, contact.b}) {
      const std::uint32_t slot = part_.slot_of(name);
      if (slot == pbd::BodyId::kNone || to[slot] == ranks_.rank() || to[slot] == sent) continue;
      sent = to[slot];
      MessageWriter writer(out[static_cast<std::size_t>(sent)]);
      write_contact(contact, writer);
    }
  }
  for (const auto& [slot, rank] : moves) part_.remove(slot);
  arrived_.assign(world_.slot_count(), 0);
  for (const Bytes& bytes : ranks_.exchange(out)) read_section(bytes);
}

/// Reads bodies with their contacts.
void Cluster::Impl::read_section(const Bytes& bytes) {
  if (bytes.empty()) return;
  MessageReader in(bytes);
  const auto bodies = in.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < bodies; ++i) {
    const std::uint32_t slot = part_.read(in, false);
    if (slot == pbd::BodyId::kNone) Environment::abort("a body that was sent is none");
    if (slot >= arrived_.size()) arrived_.resize(slot + 1, 0);
    arrived_[slot] = 1;
  }
  while (in.remaining() > 0 && !in.failed()) {
    const NamedContact contact = read_contact(in);
    if (contacts_ != nullptr) {
      contacts_->carried().push_back(contact);
    } else {
      alone_.push_back(contact);
    }
  }
}

std::int64_t Cluster::Impl::agree_on(std::int64_t said) {
  Bytes bytes;
  MessageWriter(bytes).put(said);
  return ranks_.gather(bytes)[0].get<std::int64_t>();
}

Totals Cluster::Impl::totals() {
  Totals own;
  const pbd::Vec3& gravity = world_.gravity();
  for (const std::uint32_t slot : part_.own()) {
    const pbd::BodyState& state = world_.states()[slot];
    const pbd::BodyProps& props = world_.all_props()[slot];
    const pbd::Vec3 w_l = state.pose.orientation.conjugate() * state.twist.angular;
    const double kinetic =
        0.5 * (props.mass * state.twist.linear.squaredNorm() + w_l.dot(props.inertia * w_l));
    ++own.bodies;
    own.awake += world_.awake_at(slot) ? 1 : 0;
    own.kinetic_energy += kinetic;
    own.mechanical_energy +=
        kinetic - props.mass * props.gravity_scale * gravity.dot(state.pose.position);
    own.momentum += props.mass * state.twist.linear;
    Bytes bytes;
    MessageWriter out(bytes);
    out.put(part_.name(slot));
    write_state(state, out);
    own.hash += pbd::hash_bytes(bytes);
  }
  Bytes bytes;
  MessageWriter out(bytes);
  out.put(own.bodies);
  out.put(own.awake);
  out.put(own.kinetic_energy);
  out.put(own.mechanical_energy);
  out.vec3(own.momentum);
  out.put(own.hash);
  Totals all;
  for (MessageReader& in : ranks_.gather(bytes)) {
    all.bodies += in.get<std::size_t>();
    all.awake += in.get<std::size_t>();
    all.kinetic_energy += in.get<double>();
    all.mechanical_energy += in.get<double>();
    all.momentum += in.vec3();
    all.hash += in.get<std::uint64_t>();
  }
  return all;
}

Cluster::Cluster(const ClusterOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(options);
}
Cluster::~Cluster() = default;
int Cluster::rank() const { return impl_->ranks().rank(); }
int Cluster::count() const { return impl_->ranks().count(); }
pbd::BodyId Cluster::add(const pbd::BodyDef& def,
                         std::span<const collision::ColliderDef> colliders) {
  return impl_->add(def, colliders);
}
void Cluster::use(const collision::Hull& hull) { impl_->use(hull); }
void Cluster::start() { impl_->start(); }
const pbd::StepReport& Cluster::step(double dt) { return impl_->step(dt); }
pbd::World& Cluster::world() { return impl_->world(); }
const pbd::World& Cluster::world() const { return impl_->world(); }
const collision::CollisionScene& Cluster::shapes() const { return impl_->shapes(); }
bool Cluster::owns(pbd::BodyId body) const {
  return impl_->world().contains(body) && impl_->part().is_own(body.index);
}
pbd::BodyId Cluster::own_body(std::uint64_t stable_id) const {
  const std::uint32_t slot = impl_->part().slot_of(stable_id);
  if (slot == pbd::BodyId::kNone || !impl_->part().is_own(slot)) return {};
  return impl_->world().body_at(slot);
}
std::int64_t Cluster::agree_on(std::int64_t said) { return impl_->agree_on(said); }
const StepCost& Cluster::cost() const { return impl_->cost(); }
const ClusterState& Cluster::state() const { return impl_->state(); }
Totals Cluster::totals() { return impl_->totals(); }
std::uint64_t Cluster::steps() const { return impl_->steps(); }
void Cluster::save(const std::string& path) { impl_->save(path); }
void Cluster::load(const std::string& path) { impl_->load(path); }

}  // namespace tandem::mpi
