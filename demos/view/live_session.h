// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runner/virtual_runner.h"
#include "view/live_worlds.h"
#include "view/protocol.h"

namespace tandem::demos::view {

/// A run in virtual time that goes on as far as it is asked to, and does what pages ask in between.
/// It knows no clock and no page's socket: same calls, same bits.
///
/// Beside it the same run may be shown with another coupling: both begin together and go on in
/// lockstep, and the same users act in both, scripted ones and those at pages. Panes are the peers
/// of the run, then those of the run beside it.
/// @par Thread safety  One object: one thread at a time.
class LiveSession {
 public:
  /// The scenario must outlive it. Where the options have no end, nothing is recorded.
  /// @throws as run_virtual
  LiveSession(const Scenario& scenario, const DemoOptions& options);

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
  /// How many panes there are now.
  std::size_t panes() const { return beside_ ? 2 * peers() : peers(); }
  const Scene& scene(std::size_t pane) const { return worlds(pane).scene(pane % peers()); }
  std::size_t grips(std::size_t pane) const { return worlds(pane).mouse(pane % peers()).grips(); }
  /// What there is to see now. Allocates only where `out` grows.
  void show(Frame& out, bool overlays);
  /// What each pane's peer and its users have achieved so far.
  std::vector<Outcome> outcomes();
  /// What was recorded so far, of the run alone, not of the one beside it.
  RunResult result();

 private:
  std::size_t peers() const { return run_->size(); }
  const LiveWorlds& worlds(std::size_t pane) const { return pane < peers() ? *run_ : *beside_; }
  void grab(PageId page, const Grab& grab);
  /// What is done by each mouse of both runs.
  template <class Action>
  void each_mouse(const Action& act);
  void set_profile(int profile);
  void set_beside(std::optional<Scheme> scheme);
  /// Agree by other rules from now on. @throws std::invalid_argument where they are not valid
  void change_rules(const DemoOptions& options);
  DemoOptions beside_options() const;

  const Scenario& scenario_;
  DemoOptions options_;
  std::optional<Scheme> beside_scheme_;  ///< of the run beside; none: there is no such run
  bool paused_ = false;
  double speed_ = 1.0;  ///< session time over wall time
  Layout layout_;
  std::optional<std::vector<Input>> replay_;
  std::unique_ptr<LiveWorlds> run_;     ///< there between calls
  std::unique_ptr<LiveWorlds> beside_;  ///< null: nothing is shown beside it
  consensus::SessionTime now_ = kVirtualStart;
};

}  // namespace tandem::demos::view
