// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/session.h"

#include <functional>
#include <string_view>

#include "session_impl.h"
#include "sharing.h"
#include "tandem/pbd/validate.h"
#include "transport_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

/// A call on the session.
template <class Call>
tandem_result on_session(tandem_session* session, tandem_error* error, Call&& call) {
  return guarded(error, [&] { call(*required(session, "session").session); });
}

/// Sets a flag for its lifetime.
class Advancing {
 public:
  explicit Advancing(tandem_session& session) : session_(session) {
    if (session.advancing) {
      pbd::detail::refuse("tandem_session_advance", "called by no function that it calls");
    }
    session.advancing = true;
  }
  ~Advancing() { session_.advancing = false; }
  Advancing(const Advancing&) = delete;
  Advancing& operator=(const Advancing&) = delete;

 private:
  tandem_session& session_;
};

tandem_step_status status_of(pbd::StepStatus status) {
  switch (status) {
    case pbd::StepStatus::Ok:
      return TANDEM_STEP_OK;
    case pbd::StepStatus::NonFinite:
      return TANDEM_STEP_NON_FINITE;
    case pbd::StepStatus::InvalidStep:
      break;
  }
  return TANDEM_STEP_INVALID;
}

}  // namespace

void tandem_session::listen() {
  session->on_join([this](PeerId peer) { joined.push_back(peer); });
  session->on_leave([this](PeerId peer) { left.push_back(peer); });
}

void tandem_session::hear() {
  for (const consensus::Event& event : session->events().received()) {
    if (!event.topic.starts_with("tandem.")) events.push_back(event);
  }
}

tandem_session* tandem_session_create(tandem_world* world, tandem_transport* transport,
                                      const tandem_session_def* def, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_transport& wire = required(transport, "transport");
    SessionOptions options = options_of(required(def, "def"));
    if (!options.clock) options.clock = wire.clock;
    return opened(required(world, "world"), *wire.transport, options).release();
  });
}

void tandem_session_destroy(tandem_session* session) { delete session; }

uint64_t tandem_session_self(const tandem_session* session) {
  return session != nullptr ? session->session->transport().self() : 0;
}

int32_t tandem_session_port(const tandem_session* session) {
  return session != nullptr && session->port ? session->port() : 0;
}

int64_t tandem_session_now(tandem_session* session) {
  int64_t now = 0;
  guarded(nullptr, [&] { now = required(session, "session").session->now(); });
  return now;
}

tandem_result tandem_session_advance(tandem_session* session, int64_t now_ns,
                                     tandem_before_step before_step, void* user,
                                     tandem_progress* progress, tandem_error* error) {
  return guarded(error, [&] {
    tandem_session& s = required(session, "session");
    const SessionTime now = checked_time("now_ns", now_ns, -consensus::kMaxStamp);
    const Advancing advancing(s);
    s.joined.clear();
    s.left.clear();
    s.events.clear();
    // Captured by reference: copying would allocate in each call.
    const auto each_step = [&](SessionTime time) {
      s.hear();
      if (before_step != nullptr) before_step(user, time);
    };
    const Progress done = s.session->advance(now, std::cref(each_step));
    if (progress == nullptr) return;
    *progress = {.steps = done.steps,
                 .status = status_of(done.status),
                 .skipped_ns = done.skipped,
                 .lag_ns = done.lag,
                 .held_ns = done.held,
                 .stepped_elsewhere = done.stepped_elsewhere ? 1 : 0};
  });
}

tandem_result tandem_session_share(tandem_session* session, const char* name, tandem_body body,
                                   uint64_t owner, tandem_shared_id* id, tandem_error* error) {
  return on_session(session, error, [&](Session& s) {
    const SharedId shared = s.share(&required(name, "name"), from_c(body), owner_of(owner));
    if (id != nullptr) *id = to_c(shared);
  });
}

tandem_result tandem_session_share_all(tandem_session* session, const char* name,
                                       const tandem_body* bodies, size_t count, uint64_t owner,
                                       tandem_error* error) {
  return on_session(session, error, [&](Session& s) {
    std::vector<pbd::BodyId> ids;
    for (size_t i = 0; i < count; ++i) ids.push_back(from_c((&required(bodies, "bodies"))[i]));
    s.share(&required(name, "name"), ids, owner_of(owner));
  });
}

tandem_result tandem_session_unshare(tandem_session* session, tandem_shared_id id,
                                     tandem_error* error) {
  return on_session(session, error, [&](Session& s) { s.unshare(from_c(id)); });
}

tandem_result tandem_session_body(const tandem_session* session, tandem_shared_id id,
                                  tandem_body* body, tandem_error* error) {
  return guarded(error, [&] {
    const tandem_session& s = required(session, "session");
    tandem_body& out = required(body, "body");
    const pbd::BodyId found = s.session->peer().body_of(from_c(id));
    if (found == pbd::BodyId{}) {
      pbd::detail::refuse("id", "of a body that is shared", from_c(id).to_string());
    }
    out = to_c(found);
  });
}

tandem_result tandem_session_grab(tandem_session* session, const tandem_grab_def* def,
                                  uint32_t* grab, tandem_error* error) {
  return on_session(session, error, [&](Session& s) {
    const GrabDef wanted = from_c(required(def, "def"));
    uint32_t& out = required(grab, "grab");
    out = s.grab(wanted).spring;
  });
}

tandem_result tandem_session_move(tandem_session* session, uint32_t grab, tandem_vec3 anchor,
                                  int32_t* holds, tandem_error* error) {
  return on_session(session, error, [&](Session& s) {
    const bool held = s.move({grab}, from_c(anchor));
    if (holds != nullptr) *holds = held ? 1 : 0;
  });
}

tandem_result tandem_session_release(tandem_session* session, uint32_t grab, tandem_error* error) {
  return on_session(session, error, [&](Session& s) { s.release({grab}); });
}

tandem_result tandem_session_act(tandem_session* session, const tandem_act_def* def,
                                 tandem_error* error) {
  return on_session(session, error, [&](Session& s) { s.act(from_c(required(def, "def"))); });
}

tandem_result tandem_session_spawn(tandem_session* session, const char* what,
                                   const tandem_pose* pose, const tandem_twist* twist,
                                   tandem_shared_id* id, tandem_error* error) {
  return on_session(session, error, [&](Session& s) {
    const SharedId made = s.spawn(&required(what, "what"), from_c(required(pose, "pose")),
                                  twist != nullptr ? from_c(*twist) : pbd::Twist{});
    if (id != nullptr) *id = to_c(made);
  });
}

tandem_result tandem_session_despawn(tandem_session* session, tandem_shared_id id,
                                     tandem_error* error) {
  return on_session(session, error, [&](Session& s) { s.despawn(from_c(id)); });
}
