// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "copies/measures.h"
#include "tandem/pbd/math.h"

namespace tandem::extreme_bench {
namespace {

using peers_bench::Site;

/// Springs of all users, always in the same order.
template <class Visit>
void for_each_spring(const pbd::World& world, Visit&& visit) {
  constexpr std::uint32_t kMax = 16;  // springs, and releases
  for (const auto& block : world.blocks()) {
    const auto* tethers = dynamic_cast<const pbd::Tethers*>(block.get());
    if (tethers == nullptr) continue;
    for (std::uint32_t i = 0; i < kMax; ++i) {
      for (std::uint32_t generation = 0; generation < kMax; ++generation) {
        const pbd::ConstraintId id{i, generation};
        if (tethers->contains(id)) visit(tethers->at(id));
      }
    }
  }
}

}  // namespace

Sample sample(const std::vector<std::unique_ptr<Site>>& sites) {
  Sample result;
  const std::size_t bodies = sites.front()->copy.bodies.size();
  for (std::size_t i = 0; i < bodies; ++i) {
    double apart = 0.0;
    double turned = 0.0;
    for (std::size_t a = 0; a < sites.size(); ++a) {
      const pbd::BodyState& one = sites[a]->copy.world->state(sites[a]->copy.bodies[i]);
      result.finite = result.finite && one.pose.position.allFinite() &&
                      one.pose.orientation.coeffs().allFinite() && one.twist.linear.allFinite() &&
                      one.twist.angular.allFinite();
      for (std::size_t b = 0; b < a; ++b) {
        const pbd::Pose& other = sites[b]->copy.world->pose(sites[b]->copy.bodies[i]);
        apart = std::max(apart, (one.pose.position - other.position).norm());
        turned =
            std::max(turned, pbd::rotation_between(one.pose.orientation, other.orientation).norm());
      }
    }
    result.apart += apart * apart;
    result.turned += turned * turned;
  }
  result.apart = std::sqrt(result.apart / static_cast<double>(bodies));
  result.turned = std::sqrt(result.turned / static_cast<double>(bodies));
  for (const auto& site : sites) {
    result.overlap = std::max(result.overlap, peers_bench::deepest_overlap(site->copy));
    result.joint_error = std::max(result.joint_error, peers_bench::widest_joint(site->copy));
  }
  return result;
}

EnergyAccount::EnergyAccount(const Site& site) : kinetic(site.copy.world->kinetic_energy()) {}

double EnergyAccount::weight_power(const Site& site) {
  const pbd::World& world = *site.copy.world;
  double sum = 0.0;
  for (const pbd::BodyId body : site.copy.bodies) {
    sum += world.props(body).mass * world.gravity().dot(world.twist(body).linear);
  }
  return sum;
}

void EnergyAccount::begun(const Site& site) {
  const pbd::World& world = *site.copy.world;
  kinetic = world.kinetic_energy();
  power_ = weight_power(site);
  pulls_.clear();
  for_each_spring(world, [&](const pbd::Tether& spring) {
    const pbd::Tether::Def& def = spring.def();
    pulls_.push_back(
        {def.body, def.anchor_l, world.pose(def.body).to_world(def.anchor_l), spring.force()});
  });
}

void EnergyAccount::stepped(const Site& site, const pbd::StepReport& report, double dt) {
  const pbd::World& world = *site.copy.world;
  kinetic = world.kinetic_energy();
  work += 0.5 * dt * (power_ + weight_power(site));
  std::size_t next = 0;
  for_each_spring(world, [&](const pbd::Tether& spring) {
    const Pull& pull = pulls_[next++];
    const pbd::Pose& pose = world.pose(pull.body);
    const pbd::Correction agreed = world.correction(pull.body);
    const Vec3 arm = pose.orientation * pull.arm_l;
    const Vec3 way =
        pose.position + arm - pull.at - agreed.translation - agreed.rotation.cross(arm);
    work += 0.5 * (pull.force + spring.force()).dot(way);
  });
  displacement = std::max(displacement, std::abs(report.energy.displacement));
  if (report.status != pbd::StepStatus::Ok) ++bad_steps;
}

Watch::Watch(const Scene& scene, peers_bench::Session& session) : scene_(scene), session_(session) {
  accounts_.reserve(session.sites.size());
  for (const auto& site : session.sites) {
    accounts_.emplace_back(*site);
    EnergyAccount& account = accounts_.back();
    site->begun = [&account](Site& s) { account.begun(s); };
    site->stepped = [&account](Site& s, const pbd::StepReport& report, double dt) {
      account.stepped(s, report, dt);
    };
    start_kinetic_ += account.kinetic;
    for (const pbd::BodyId body : site->copy.bodies) {
      lowest_.push_back(site->copy.world->pose(body).position.z());
    }
  }
  result_.excess_J = -std::numeric_limits<double>::infinity();
  look();
}

double Watch::difference(const Sample& s) const {
  return scene_.by_angle ? s.turned * 180.0 / std::numbers::pi : 1e3 * s.apart;
}

void Watch::look() {
  samples_.push_back(sample(session_.sites));
  if (!samples_.back().finite) ++not_finite_;
  double kinetic = 0.0;
  double work = 0.0;
  for (const EnergyAccount& account : accounts_) {
    kinetic += account.kinetic;
    work += account.work;
  }
  if (kinetic > result_.kinetic_J) {
    result_.kinetic_J = kinetic;
    result_.work_J = work;
  }
  result_.excess_J = std::max(result_.excess_J, kinetic - start_kinetic_ - work);
}

Result Watch::finish() {
  const std::size_t n = samples_.size();
  std::vector<double> worst_from(n + 1, 0.0);  // over all later samples
  for (std::size_t k = n; k-- > 0;) {
    const Sample& s = samples_[k];
    worst_from[k] = std::max(worst_from[k + 1], difference(s));
    result_.overlap_mm = std::max(result_.overlap_mm, 1e3 * s.overlap);
    result_.joint_mm = std::max(result_.joint_mm, 1e3 * s.joint_error);
  }
  std::vector<double> series;  // difference per sample, mm or degrees
  for (const Sample& s : samples_) series.push_back(difference(s));
  const auto worst = [&](std::size_t from, std::size_t to) {
    return *std::max_element(series.begin() + static_cast<std::ptrdiff_t>(from),
                             series.begin() + static_cast<std::ptrdiff_t>(to));
  };
  const auto second = static_cast<std::size_t>(scene_.sample_hz);
  for (std::size_t k = n - second; k < n; ++k) {
    result_.overlap_end_mm += 1e3 * samples_[k].overlap / static_cast<double>(second);
  }
  const double start = series.front();
  const double frames = 60.0 / scene_.sample_hz;
  const auto until = [&](double limit) {
    for (std::size_t k = 0; k < n; ++k) {
      if (worst_from[k] < limit) return static_cast<int>(static_cast<double>(k) * frames);
    }
    return -1;
  };
  if (start > 0.0) {
    result_.half_frames = until(0.5 * start);
    result_.percent_frames = until(0.01 * start);
    result_.millimetre_frames = until(1.0);
  }
  result_.peak_mm = worst_from[0];
  result_.final_mm = worst(n - second, n);
  for (const EnergyAccount& account : accounts_) {
    result_.displacement_J = std::max(result_.displacement_J, account.displacement);
    not_finite_ += account.bad_steps;
  }
  bool standing = true;
  std::size_t body = 0;
  for (const auto& site : session_.sites) {
    for (const pbd::BodyId id : site->copy.bodies) {
      const double sunk = lowest_[body++] - site->copy.world->pose(id).position.z();
      if (scene_.stands && !(sunk < 0.5 * kHalf)) standing = false;
    }
  }
  // Moving copies differ by the age of the updates.
  const double bound = start + 1e3 * scene_.differs + (scene_.by_angle ? 10.0 : 1000.0);
  // Noise differs between quarters. With loss, chance places the longest gap and so the maximum:
  // there the rms shows growth.
  const auto rms = [&](std::size_t from, std::size_t to) {
    double sum = 0.0;
    for (std::size_t k = from; k < to; ++k) sum += series[k] * series[k];
    return std::sqrt(sum / static_cast<double>(to - from));
  };
  const bool lossy = scene_.conditions.loss > 0.0;
  const double before = lossy ? rms(n / 2, 3 * n / 4) : worst(n / 2, 3 * n / 4);
  const double last = lossy ? rms(3 * n / 4, n) : worst(3 * n / 4, n);
  result_.stable =
      not_finite_ == 0 && standing && result_.peak_mm < bound && last < 1.5 * before + 1.0;
  return result_;
}

}  // namespace tandem::extreme_bench
