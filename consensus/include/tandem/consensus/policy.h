// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "tandem/consensus/influence.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// What an influence policy may go by. Fields that are not known at the place where a policy is
/// asked hold their defaults.
struct TANDEM_API InfluenceContext {
  bool owned = false;        ///< the body has an owner
  bool sender_owns = false;  ///< who announces the share is the owner
  bool held_alone = false;   ///< a user holds it by a constraint that no other peer simulates
  /// 0 to 1: this peer's user was the last to act on it, and the only one; the others only know an
  /// earlier state of it. Fades out.
  double leads = 0.0;
  /// 0 to 1: how long this peer has been in the session, see PeerOptions::authority_ramp.
  double confidence = 1.0;
  double age = 0.0;  ///< s, of the update
  double heard_for =
      std::numeric_limits<double>::infinity();  ///< s, since the sender's first state
  double variance = 0.0;  ///< m^2, the predictor's own estimate of its error; 0 = not known
  // Between the carried state and the own one.
  double distance = 0.0;       ///< m
  double angle = 0.0;          ///< rad
  double speed = 0.0;          ///< m/s
  double angular_speed = 0.0;  ///< rad/s

  friend bool operator==(const InfluenceContext&, const InfluenceContext&) = default;
};

/// One rule of influence: makes a share from the share that the rules before it have left.
/// Stateless, so that one object serves all bodies and peers, and need not be asked again where
/// nothing has changed.
class TANDEM_API InfluencePolicy {
 public:
  virtual ~InfluencePolicy() = default;
  /// @return a share in [0, 1]; share >= 1 is an owner's
  virtual double apply(double share, const InfluenceContext& context) const = 0;
};

/// Rules in the order in which they apply. Copies share the rules, which do not change.
class TANDEM_API PolicyChain {
 public:
  PolicyChain() = default;
  PolicyChain& then(std::shared_ptr<const InfluencePolicy> policy);
  bool empty() const { return policies_.empty(); }
  double apply(double share, const InfluenceContext& context) const {
    for (const auto& policy : policies_) share = policy->apply(share, context);
    return share;
  }

 private:
  std::vector<std::shared_ptr<const InfluencePolicy>> policies_;
};

// Of the share that a peer announces for its own states. All throw std::invalid_argument, naming
// value and rule.

/// `share`, whatever was before. 5 to 10 % in [friston] Sec. 6.3.
TANDEM_API std::shared_ptr<const InfluencePolicy> baseline(double share);
/// At least `share` while this peer alone knows what its user does to the body, [friston] Sec. 3.2.
TANDEM_API std::shared_ptr<const InfluencePolicy> raised_while_held_alone(double share);
/// At least `share` while this peer leads; 0 stays 0.
TANDEM_API std::shared_ptr<const InfluencePolicy> raised_while_leading(double share);
/// Times the confidence: the authority grows from zero at the start, [friston] Sec. 7.7.
TANDEM_API std::shared_ptr<const InfluencePolicy> authority_ramp();
/// 1 from the owner, 0 from all others, where there is one.
TANDEM_API std::shared_ptr<const InfluencePolicy> owner_alone();

// Of the share that was heard, before the state is carried to now.

/// Halves with each `half_life` (s) of age, 0 beyond `max_age` (s); owners' only expires.
TANDEM_API std::shared_ptr<const InfluencePolicy> age_decay(double half_life, double max_age);
// Of the share that is left, after the state was carried to now; not for owners.

/// Times r^2 / (r^2 + variance): a state whose predictor expects an error of `distance` (m) counts
/// half, [friston] Sec. 8.1.
TANDEM_API std::shared_ptr<const InfluencePolicy> modelled_error(double distance);
/// Grows from 0 over `seconds` since the sender was first heard: damped corrections at start-up,
/// [friston] Sec. 7.7.
TANDEM_API std::shared_ptr<const InfluencePolicy> damped_start(double seconds);

/// Differences below all of these are left alone; [friston] Sec. 4.6's values.
struct TANDEM_API SleepLimits {
  double distance = 1e-3;               ///< m
  double angle = 0.017453292519943295;  ///< rad, 1 degree
  double speed = 1e-2;                  ///< m/s
  double angular_speed = 1e-2;          ///< rad/s
};
/// 0 where the states differ by less than the limits: noise does not keep bodies awake.
TANDEM_API std::shared_ptr<const InfluencePolicy> sleeping_threshold(
    const SleepLimits& limits = {});

/// baseline, raised while held alone and while leading, authority ramp, owner.
TANDEM_API PolicyChain default_announcement(const InfluenceOptions& options);
/// Age decay, the same as effective_share().
TANDEM_API PolicyChain default_hearing(const InfluenceOptions& options);

}  // namespace tandem::consensus
