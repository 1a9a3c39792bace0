// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/policy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/pbd/typed_block.h"

namespace tandem::consensus {

using pbd::detail::require;

namespace {

void require_share(const char* policy, double value) {
  require(value >= 0.0 && value <= 1.0, policy, "share", value, "0 to 1");
}
void require_positive(const char* policy, const char* field, double value) {
  require(value > 0.0 && std::isfinite(value), policy, field, value, "finite and above 0");
}

/// A rule made of a function of the share and the context.
template <class Rule>
class RulePolicy final : public InfluencePolicy {
 public:
  explicit RulePolicy(Rule rule) : rule_(std::move(rule)) {}
  double apply(double share, const InfluenceContext& context) const override {
    return rule_(share, context);
  }

 private:
  Rule rule_;
};

template <class Rule>
std::shared_ptr<const InfluencePolicy> make(Rule rule) {
  return std::make_shared<RulePolicy<Rule>>(std::move(rule));
}

}  // namespace

PolicyChain& PolicyChain::then(std::shared_ptr<const InfluencePolicy> policy) {
  if (policy == nullptr) {
    throw std::invalid_argument("PolicyChain: policy = null breaks the rule: not null");
  }
  policies_.push_back(std::move(policy));
  return *this;
}

std::shared_ptr<const InfluencePolicy> baseline(double share) {
  require_share("baseline", share);
  return make([share](double, const InfluenceContext&) { return share; });
}

std::shared_ptr<const InfluencePolicy> raised_while_held_alone(double share) {
  require_share("raised_while_held_alone", share);
  return make([share](double before, const InfluenceContext& context) {
    return context.held_alone ? std::max(before, share) : before;
  });
}

std::shared_ptr<const InfluencePolicy> raised_while_leading(double share) {
  require_share("raised_while_leading", share);
  return make([share](double before, const InfluenceContext& context) {
    return before > 0.0 && context.leads >= 1.0 ? std::max(before, share) : before;
  });
}

std::shared_ptr<const InfluencePolicy> authority_ramp() {
  return make(
      [](double share, const InfluenceContext& context) { return share * context.confidence; });
}

std::shared_ptr<const InfluencePolicy> owner_alone() {
  return make([](double share, const InfluenceContext& context) {
    if (!context.owned) return share;
    return context.sender_owns ? 1.0 : 0.0;
  });
}

std::shared_ptr<const InfluencePolicy> age_decay(double half_life, double max_age) {
  require_positive("age_decay", "half_life", half_life);
  require_positive("age_decay", "max_age", max_age);
  return make([half_life, max_age](double share, const InfluenceContext& context) {
    if (!(share > 0.0) || !(context.age <= max_age)) return 0.0;
    if (share >= 1.0) return 1.0;
    return share * std::exp2(-std::max(context.age, 0.0) / half_life);
  });
}

std::shared_ptr<const InfluencePolicy> modelled_error(double distance) {
  require_positive("modelled_error", "distance", distance);
  return make([square = distance * distance](double share, const InfluenceContext& context) {
    if (share >= 1.0 || !(context.variance > 0.0)) return share;
    return share * square / (square + context.variance);
  });
}

std::shared_ptr<const InfluencePolicy> damped_start(double seconds) {
  require_positive("damped_start", "seconds", seconds);
  return make([seconds](double share, const InfluenceContext& context) {
    if (share >= 1.0) return share;
    return share * std::clamp(context.heard_for / seconds, 0.0, 1.0);
  });
}

std::shared_ptr<const InfluencePolicy> sleeping_threshold(const SleepLimits& limits) {
  require_positive("sleeping_threshold", "distance", limits.distance);
  require_positive("sleeping_threshold", "angle", limits.angle);
  require_positive("sleeping_threshold", "speed", limits.speed);
  require_positive("sleeping_threshold", "angular_speed", limits.angular_speed);
  return make([limits](double share, const InfluenceContext& context) {
    const bool apart = context.distance > limits.distance || context.angle > limits.angle ||
                       context.speed > limits.speed || context.angular_speed > limits.angular_speed;
    return share >= 1.0 || apart ? share : 0.0;
  });
}

PolicyChain default_announcement(const InfluenceOptions& options) {
  PolicyChain chain;
  chain.then(baseline(options.baseline))
      .then(raised_while_held_alone(options.held_alone))
      .then(raised_while_leading(options.leading))
      .then(authority_ramp())
      .then(owner_alone());
  return chain;
}

PolicyChain default_hearing(const InfluenceOptions& options) {
  PolicyChain chain;
  chain.then(age_decay(options.half_life, options.max_age));
  return chain;
}

}  // namespace tandem::consensus
