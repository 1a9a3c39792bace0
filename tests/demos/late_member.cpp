// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "late_member.h"

#include <algorithm>
#include <cmath>

#include "session/actor.h"
#include "tandem/consensus/update.h"

namespace tandem::demos::late_member_test {

using consensus::SessionTime;
using consensus::StateUpdate;

namespace {

constexpr std::size_t kKept = 80;  ///< steps: more than the longest age

}  // namespace

LateMember::LateMember(VirtualSession& session, const Saying& saying)
    : session_(session), saying_(saying), line_(session.network().transport(kId)) {}

const LateMember::Shot& LateMember::shot_for(SessionTime now) {
  double age = ++turns_ % 2 == 0 ? saying_.age : saying_.other_age;
  if (saying_.mixed) age = dice_.uniform(saying_.age, saying_.other_age);
  return *std::ranges::min_element(past_, {}, [&](const Shot& shot) {
    return std::abs(1e-9 * static_cast<double>(now - shot.time) - age);
  });
}

void LateMember::look(SessionTime now) {
  Actor& truth = session_.actors()[0];
  if (truth.reached() == last_) return;
  last_ = truth.reached();
  const Scene& scene = truth.participant().scene();
  Shot& shot = past_.emplace_back(Shot{last_, {}});
  for (const SceneBody& body : scene.bodies) {
    shot.states.push_back(scene.world->state(body.body));
  }
  if (past_.size() > kKept) past_.pop_front();
  const double passed = 1e-9 * static_cast<double>(now - kVirtualStart);
  if (passed < kSpeaks || ++steps_ % saying_.every != 0) return;
  const Shot& then = shot_for(now);
  std::vector<StateUpdate> says;
  for (std::size_t i = 0; i < std::min(saying_.bodies, then.states.size()); ++i) {
    StateUpdate update{.id = scene.bodies[i].id,
                       .pose = then.states[i].pose,
                       .twist = then.states[i].twist,
                       .influence = static_cast<float>(saying_.influence),
                       .stamp = then.time,
                       .flags = {.leads = saying_.leads}};
    update.pose.position.x() += saying_.aside;
    says.push_back(update);
  }
  std::vector<std::byte> bytes;
  encode(says, bytes);
  for (std::size_t i = 0; i < session_.actors().size(); ++i) {
    line_.post(i + 1, bytes, consensus::Delivery::Newest);
  }
}

}  // namespace tandem::demos::late_member_test
