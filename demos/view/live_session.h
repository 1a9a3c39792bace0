// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runner/virtual_runner.h"
#include "runner/virtual_session.h"
#include "view/mouse.h"
#include "view/pane_watch.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// A run in virtual time that goes on as far as it is asked to, and does what pages ask in between.
/// It knows no clock and no page's socket: same calls, same bits.
/// @par Thread safety  One object: one thread at a time.
class LiveSession {
 public:
  /// The scenario must outlive it. Where the options have no end, nothing is recorded.
  /// @throws as run_virtual
  LiveSession(const Scenario& scenario, const DemoOptions& options);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// s, since the start.
  double time() const;
  /// Everything that happens up to `time` (s, since the start) happens; times before time() change
  /// nothing.
  void advance_to(double time);
  /// Go on as far as the settings say for so much wall time, s: not at all where it is paused.
  void pass(double wall_s);
  /// From the beginning, with what is set now. Nobody holds anything then.
  void restart();

  Settings settings() const;
  /// What a page has asked for.
  /// @return a reason where it could not be done
  std::optional<std::string> apply(PageId page, const Command& command);
  /// A page is gone: it lets go.
  void leave(PageId page);

  const Layout& layout() const { return layout_; }
  const Scene& scene(std::size_t pane) const { return panes_[pane].actor->participant().scene(); }
  std::size_t grips(std::size_t pane) const { return panes_[pane].mouse->grips(); }
  /// What there is to see now. Allocates only where `out` grows.
  void show(Frame& out, bool overlays);
  /// What was recorded so far.
  RunResult result();

 private:
  struct Pane {
    Actor* actor = nullptr;
    std::unique_ptr<PaneWatch> watch;
    Mouse* mouse = nullptr;  ///< the participant's
  };
  void start();
  void close_traces();
  void set_profile(int profile);
  /// Agree by other rules from now on. @throws std::invalid_argument where they are not valid
  void change_rules(const DemoOptions& options);
  void show_divergence(Frame& out);
  void show_springs(std::size_t pane, std::vector<SpringMark>& out);
  std::size_t pane_of(consensus::PeerId peer) const;  ///< SIZE_MAX: none

  const Scenario& scenario_;
  DemoOptions options_;
  bool paused_ = false;
  double speed_ = 1.0;  ///< session time over wall time
  Layout layout_;
  std::optional<std::vector<Input>> replay_;
  std::optional<VirtualSession> session_;  ///< there between calls
  std::vector<Pane> panes_;
  consensus::SessionTime now_ = kVirtualStart;
  // Scratch.
  std::vector<pbd::Vec3> means_;
  std::vector<pbd::Vec3> positions_;
  std::vector<double> lengths_;
  std::vector<pbd::Tether::Def> pulls_;
};

}  // namespace tandem::demos::view
