// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "scenes/inputs.h"
#include "scenes/scene.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// A one-time event at all peers, at a session time.
struct Signal {
  std::uint32_t code = 0;           ///< defined by the scenario
  consensus::SessionTime time = 0;  ///< ns
  friend auto operator<=>(const Signal&, const Signal&) = default;
};

/// Carries a signal to all peers, this one included.
class SignalSink {
 public:
  virtual ~SignalSink() = default;
  virtual void raise(const Signal& signal) = 0;
};

/// All that users can do to their peer's world, and the record of it.
/// @par Thread safety  One object: one thread at a time.
class Controls {
 public:
  /// All must outlive it. @param epoch  ns, session time of the script's beginning
  /// @param signals  null: signals are recorded but not sent
  Controls(std::size_t user, Scene& scene, consensus::Peer& peer, consensus::SessionTime epoch,
           SignalSink* signals = nullptr);

  /// The peer's clock is `ahead` ns of ours.
  void set_clock(consensus::SessionTime ahead) { clock_ahead_ = ahead; }
  /// Subsequent inputs happen at `now`, before a step of `dt` s.
  void begin(consensus::SessionTime now, double dt);
  double time() const { return 1e-9 * static_cast<double>(now_ - epoch_); }  ///< s since the epoch
  consensus::SessionTime now() const { return now_; }
  double dt() const { return dt_; }
  const Scene& scene() const { return scene_; }

  /// Attaches a spring to a shared body, in the peer's mode; returns its number.
  /// @throws as consensus::Peer::grab
  std::uint32_t grab(std::size_t body, const consensus::GrabDef& def);
  /// The same spring, known to this peer alone: an asymmetric constraint, [friston] Sec. 3.5. The
  /// others see only its effect on the body.
  std::uint32_t hold(std::size_t body, const consensus::GrabDef& def);
  void move(std::uint32_t spring, const pbd::Vec3& anchor_w);
  void release(std::uint32_t spring);
  /// Moves one of this user's own bodies to `pose` at the end of the step. No effect if the body is
  /// not driven from this peer.
  void drive(std::size_t body, const pbd::Pose& pose);
  /// Teleports one of this user's own bodies.
  void jump(std::size_t body, const pbd::Pose& pose);
  /// @param delay  s, from now
  void signal(std::uint32_t code, double delay);

  /// By any spring.
  bool holds(std::size_t body) const;
  /// The same for a spring at exactly this point (m, frame of the body).
  bool holds(std::size_t body, const pbd::Vec3& attachment_l) const;
  /// Distance of a spring's attachment on the body from its anchor.
  struct Stretch {
    std::size_t body = 0;   ///< index into Scene::bodies
    double distance = 0.0;  ///< m
  };
  /// In this peer's present world; appends.
  void append_stretches(std::vector<Stretch>& out) const;
  /// Restores all springs after the peer was replaced in place.
  void hold_again();
  /// Newest last.
  const std::vector<Input>& log() const { return log_; }
  /// Clears the record at each begin(): for endless sessions.
  void keep_no_log() {
    log_.clear();
    keeps_log_ = false;
  }

 private:
  struct Spring {
    consensus::GrabId id;
    std::size_t body = 0;
    consensus::GrabDef def = {};
  };
  std::uint32_t add(Input::Kind kind, std::size_t body, const consensus::GrabDef& def,
                    std::optional<consensus::InputMode> mode);
  Input& note(Input::Kind kind, std::uint32_t object, std::size_t body);

  std::size_t user_;
  Scene& scene_;
  consensus::Peer& peer_;
  consensus::SessionTime epoch_;
  SignalSink* signals_;
  consensus::SessionTime now_ = 0;
  consensus::SessionTime clock_ahead_ = 0;
  double dt_ = 1.0 / 60.0;
  std::map<std::uint32_t, Spring> springs_;
  std::uint32_t next_ = 1;
  std::vector<Input> log_;
  bool keeps_log_ = true;
};

}  // namespace tandem::demos
