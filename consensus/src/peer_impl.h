// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "body_state.h"
#include "hard_input.h"
#include "initiative.h"
#include "lead.h"
#include "names.h"
#include "outbox.h"
#include "ownership.h"
#include "replay.h"
#include "session_time.h"
#include "springs.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/consensus/budget.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/sender_clocks.h"
#include "tandem/consensus/update.h"
#include "votes.h"
#include "world_history.h"

namespace tandem::consensus {

/// What one peer does in a step. Which bodies are shared is in peer_members.cpp, receiving and
/// sending in peer_exchange.cpp, the order of a step in peer_step.cpp, newcomers and what is put
/// together again in peer_membership.cpp, who acts on what and hard inputs in peer_input.cpp,
/// prediction and fusion in peer_agreement.cpp, how far others are believed in peer_robust.cpp,
/// couplings other than the pass in peer_coupling.cpp.
class __attribute__((visibility("hidden"))) Peer::Impl {
 public:
  Impl(pbd::World& world, Transport& transport, const PeerOptions& options);

  void share(const ShareDef& def);
  void set_owner(const SharedId& id, std::optional<PeerId> owner);
  void unshare(const SharedId& id);
  std::optional<SessionTime> heard(const SharedId& id, PeerId from) const;
  std::span<const UnknownState> unknown() const { return unknown_; }
  std::optional<PeerId> owner(const SharedId& id);

  GrabId grab(const GrabDef& def) { return springs_.grab(def, at(def.body).def.body); }
  Springs& springs() { return springs_; }
  bool held(const SharedId& id) const;
  void note_contact(pbd::BodyId a, pbd::BodyId b);

  void before_step(SessionTime now);
  void after_step(SessionTime now);
  void leave(SessionTime now);
  void collect(const pbd::SolverOptions& options, std::vector<pbd::PoseTarget>& out);

  /// The world must not ask a peer that is gone for targets.
  void release_world(const Peer* peer) {
    if (world_.target_source() == peer) world_.set_target_source(nullptr);
  }

  const PeerStats& stats() {
    stats_.inbox = inbox_.totals();
    return stats_;
  }
  std::span<const PeerReport> reports();
  SessionTime now() const { return now_; }
  void set_observer(PeerObserver* observer) { observer_ = observer; }
  void set_replay_hook(ReplayHook* hook) {
    if (replay_ != nullptr) replay_->set_hook(hook);
  }
  void set_interest(const Interest* interest) { interest_ = interest; }

 private:
  /// What the predictor keeps of another peer's states of one body.
  struct Heard {
    PeerId peer = 0;
    SessionTime last = 0;  ///< ns, when the last one was used
    PredictorMemory memory;
  };
  /// States that tell of a jump, for some of them get lost.
  static constexpr int kJumpTold = 3;
  /// m: what moves so much further in a step than its velocity says was put there.
  static constexpr double kJump = 0.1;
  // Beside Springs::Grip, what touched a body in the last step.
  static constexpr std::uint8_t kTouchedByOwn = 8;     ///< a body that this peer owns
  static constexpr std::uint8_t kTouchedByOther = 16;  ///< one that another peer owns
  static constexpr std::uint8_t kTouched = 32;         ///< any
  static constexpr std::uint8_t kJoinedToOther = 64;   ///< something that another's user acts on
  static constexpr std::uint32_t kNoName = 0xffffffff;
  struct Shared {
    ShareDef def;
    bool held = false;
    bool coupled = false;    ///< held, joined to something or touched by it
    bool joined = false;     ///< taken over from an established peer, as a newcomer does once
    int jumped = 0;          ///< states still to be sent that tell of a jump
    SessionTime landed = 0;  ///< ns, stamp of the owner's last jump that was followed
    Lead lead = {};
    Initiative initiative = {};
    LeadClaims lead_claims = {};
    std::vector<Heard> heard = {};  ///< by peer; empty where the predictor does not remember
    /// What is needed for each body in each step ends here.
    HardInput hard = {};
    pbd::Correction averaged = {};        ///< before the step, where the pass does not do it
    double still = 0.0;                   ///< s, at rest and in agreement, see rests()
    std::uint32_t name = kNoName;         ///< what the outbox calls it
    pbd::Pose lies = {};                  ///< where it has been, about, since lies_since
    SessionTime lies_since = 0;           ///< ns; 0 = it moves
    pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, what agreement wanted of this step
    bool blocked = false;                 ///< the last step did less than half of it
  };

  /// A state of another peer that counts, against the own one of its stamp.
  struct Stamped {
    SessionTime stamp = 0;  ///< ns
    pbd::BodyState state;
    bool apart = false;  ///< beyond ReplayOptions::tolerance
  };
  /// How this peer stands to the others in one body.
  struct Listening {
    bool several = false;  ///< others may be outvoted
    bool carried = false;  ///< their states are guessed for now, and not replayed
    double own_lead = 0.0;
    double own_announced = 0.0;
    double own_confidence = 0.0;
  };
  /// How the estimates of one body were found, and what they are good for.
  struct Found {
    bool votes = false;  ///< they are to be fused as votes
    /// A hand that only its own peer knows moves the body: where it is now has to be guessed.
    bool by_hand = false;
  };
  /// What agreement wants of one body.
  struct Wanted {
    Shared* shared = nullptr;
    PeerId heaviest = 0;                  ///< who has the most say in it
    bool replayed = false;                ///< where it is to be is the replay's to say
    SessionTime oldest = 0;               ///< ns, stamp of the oldest news
    pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, in the last step
    pbd::PoseTarget target;
  };
  Shared* find(const SharedId& id);
  Shared& at(const SharedId& id);

  // Receive.
  void receive(SessionTime now);
  /// What one member may have this peer do: budget of what Work counts.
  void set_budget(Budget& budget) const;
  /// False where its sender may not say so much, or it is no packet.
  bool decode_admitted(const Packet& packet, DecodedPacket& out, SessionTime now);
  /// Take out of incoming_ what that role may not say.
  void keep_allowed(PeerId from, Role role);
  /// Shift the stamps of incoming_ to the own clock.
  void date(const Packet& packet, SessionTime now);
  /// Another peer since it was first heard.
  struct Met {
    PeerId peer = 0;
    SessionTime since = 0;  ///< ns, when it was heard first,
    SessionTime last = 0;   ///< and when last
    Budget budget;
    int astray = 0;                ///< packets in a row with stamps of another time
    SessionTime astray_since = 0;  ///< ns
  };
  /// Whether the stamps in incoming_ say nothing of session time, as where its sender's clock was
  /// set and it started again.
  bool is_of_another_clock(Met& met, SessionTime now);
  /// Note that a peer was heard; make room for it. Valid until the next call.
  Met& meet(PeerId from, SessionTime now);
  /// What a peer has said counts no more.
  void part_from(PeerId peer, SessionTime now);
  void forget(PeerId peer, SessionTime now);
  void take_in(PeerId from, SessionTime now);
  void take_in_state(PeerId from, const StateUpdate& update, SessionTime farewell, SessionTime now);
  void take_in_compact(PeerId from, SessionTime farewell, SessionTime now);
  void take_in_anchors(PeerId from, SessionTime now);
  /// The state that a remote one stands for now: of what rests one that is as new as the last word
  /// of its sender, of what was rounded the one nearest to the own copy. Valid until the next call.
  const StateUpdate& as_meant(const Inbox::Received& received, const Shared& shared);
  /// Stamp of a peer's farewell; the beginning of time where it has not left.
  SessionTime farewell_of(PeerId peer) const;

  // Predict and fuse.
  void aggregate(SessionTime now);
  /// Every peer's newest state of one body, as what is between it and the own one of its stamp, or
  /// carried to now where nothing is replayed.
  Found estimate(Shared& shared, std::span<const Inbox::Received> newest, SessionTime now);
  /// A state carried to now by the predictor.
  Prediction carry(Shared& shared, PeerId from, const StateUpdate& update, SessionTime now);
  /// A state, and what the own one of its stamp misses to it.
  Stamped compare(const Shared& shared, const StateUpdate& update, Prediction& missing);
  /// What the `share` of newest[i], whose sender does not own the body, is beside the own state.
  /// @param angle  rad, between the two at its stamp     @param age  s
  double share_beside(const Shared& shared, std::span<const Inbox::Received> newest, std::size_t i,
                      double share, bool leads, double angle, double age,
                      const Listening& listening);
  /// Where somebody leads, of estimates_ only those of leaders_ and owners.
  void keep_leaders();
  /// Take over the fused estimates_ as what agreement wants.
  void want(Shared& shared, const Found& found, const pbd::Vec3& asked, SessionTime now);
  /// What stands is still where its mean with the own state `then`, of the oldest stamp, was.
  void stay(const pbd::BodyState& then, pbd::PoseTarget& target);
  /// Lessen the share of a correction that begins.
  void ease_in(const pbd::BodyState& own, Wanted& wanted) const;
  /// Make a target of what is wanted.
  void aim(Wanted& wanted);
  bool replays() const { return replay_ != nullptr && replay_->possible(); }
  /// Tell the observer of an estimate.
  void observe(Shared& shared, PeerId from, const StateUpdate& update, const Prediction& prediction,
               SessionTime now);
  /// What this peer's user does to a body in hard mode. @return whether it is so
  bool drag(Shared& shared, SessionTime now);
  /// Whether a body was put somewhere else since the last step.
  bool jumps(const Shared& shared, const pbd::Correction& correction, double dt) const;
  /// Put a body where it is said to be, whatever is in between.
  void place(Shared& shared, const pbd::BodyState& state);
  /// The same where copies are apart for good, with all that joints hold to it, and with what
  /// touches those and is apart as well: put back one by one they would be inside each other.
  void place_apart(Shared& shared, const pbd::BodyState& state, PeerId leader, SessionTime now);
  void place_along(Shared& shared, std::span<const Inbox::Received> newest, PeerId leader,
                   bool always, SessionTime now);
  /// What place_apart() takes along, into assembly_ and island_.
  void collect_island(std::uint32_t slot);
  bool hard_at_sender(const StateUpdate& update) const;
  PredictionContext context_of(Shared& shared, PeerId from, SessionTime now);
  Heard& heard_from(Shared& shared, PeerId peer, SessionTime now);
  /// The share that others should give this peer's states of a body.
  double announced(const Shared& shared) const;
  /// What this peer's own estimates weigh, against 1 for those of an established one: grows from 0
  /// after the first step, so that a newcomer takes over what the others know and is heard later.
  double confidence() const;

  /// Who acts on which body, and what follows from it, see Initiative.
  void mark_acting();
  void mark_noted_contacts();
  /// Who acts on a body acts on all that joints hold to it.
  void spread_acting();
  void update_initiative(Shared& shared, std::span<const Inbox::Received> newest, SessionTime now);

  // How far others are believed.
  PeerReport& report_of(PeerId peer);
  void receive_spring(PeerId from, const SpringUpdate& update, pbd::BodyId body, SessionTime now);
  /// Whether a peer that says so leads a body, as far as can be known here.
  bool believes_lead(Shared& shared, PeerId from, SessionTime now);
  bool owns_any(PeerId peer) const;
  /// A body comes to an owner, or goes from one; nullopt is nobody.
  void count_owner(std::optional<PeerId> owner, bool comes);
  /// Whether a hand is believed in that nobody else knows.
  bool believes_hands(std::size_t others) const;
  /// Whether more say what newest[i] says of the orientation than what is so here.
  bool outvoted_at_stamp(const Shared& shared, std::span<const Inbox::Received> newest,
                         std::size_t i);
  /// Put a body where the leader has it, the majority of several or the lower id, if nothing else
  /// helps.
  void give_way(Shared& shared, std::span<const Inbox::Received> newest, bool several,
                SessionTime now);
  /// Of several estimates_ those far from the rest count less.
  void weigh_votes(const pbd::BodyState& own);
  void note_outliers();
  /// Ask for no more than RobustOptions allow.
  void limit(const pbd::BodyState& own, Wanted& wanted);

  // Couplings other than the pass.
  /// Whether targets go into the solver's pass; those of owners do where nothing is agreed upon.
  bool in_pass() const {
    return options_.coupling == Coupling::OnePass || options_.coupling == Coupling::None;
  }
  void apply_coupling();
  /// Where bodies pass from owner to owner: who has which, and what is to be said about it.
  void update_ownership(SessionTime now);
  void hear_ownership(PeerId from, SessionTime now);
  /// The state of whoever owns the body, carried to now.
  void estimate_owner(Shared& shared, std::span<const Inbox::Received> newest, SessionTime now);
  std::size_t index_of(const Shared& shared) const {
    return static_cast<std::size_t>(&shared - shared_.data());
  }

  // Remember and send.
  void mark_joints();
  /// What touches and holds the body after the step.
  void note_grip(Shared& shared);
  void send(SessionTime now);
  /// Ask the transport who is there, into company_ and newcomers_.
  void look_around();
  /// Tell newcomers_ all that is to be known, reliably.
  void greet_newcomers();
  StateUpdate state_of(Shared& shared, SessionTime now);
  /// Whether a body has been lying still for a while.
  bool lies_still(Shared& shared, const pbd::BodyState& state, SessionTime now) const;
  /// By the outbox: what is due, to each of the others.
  void send_selected(SessionTime now);
  /// The anchors of spring_states_ into anchors_. What is left there is to be told in full.
  void encode_own_anchors();
  /// Encode into outgoing_, packets that the transport takes, and call post() for each.
  template <class Record, class Post>
  void post_records(std::span<const Record> records, std::size_t record_bytes, Delivery delivery,
                    Post&& post) {
    // What decode() takes, and what the transport does.
    const std::size_t packet = packet_limit(transport_, delivery);
    const std::size_t most = std::min(kMaxRecords, records_in(packet, record_bytes));
    while (!records.empty()) {
      const std::size_t count = std::min(most, records.size());
      outgoing_.clear();
      encode(records.first(count), outgoing_);
      post();
      records = records.subspan(count);
    }
  }
  void post_all(Delivery delivery);
  void post_to(PeerId to, Delivery delivery);
  /// The states that concern each of the others.
  void post_states();
  /// Those of states_ that concern a peer, into concerning_.
  void collect_concerning(PeerId peer);

  PeerOptions options_;
  pbd::World& world_;
  Transport& transport_;
  Springs springs_;
  WorldHistory history_;
  std::unique_ptr<Replay> replay_;  ///< null: predictor_ carries all states to now
  Inbox inbox_;
  SenderClocks sender_clocks_;
  std::shared_ptr<const Predictor> predictor_;
  std::unique_ptr<Predictor> as_stamped_ = make_predictor(PredictorKind::None);
  PeerObserver* observer_ = nullptr;
  const Interest* interest_ = nullptr;
  PeerStats stats_;
  std::vector<PeerReport> reports_;       ///< by peer
  std::vector<Shared> shared_;            ///< by id, as in inbox_
  std::unique_ptr<Outbox> outbox_;        ///< null: all in full to everybody
  NameTables names_;                      ///< of the others
  SessionTime springs_told_ = 0;          ///< ns, when springs were last sent in full
  std::unique_ptr<Ownership> ownership_;  ///< of shared_; null: bodies change no hands
  std::vector<std::pair<PeerId, SessionTime>> farewells_;
  std::vector<Met> met_;             ///< by id
  std::vector<PeerStatus> company_;  ///< all that the transport knows, by id, at the last look
  std::vector<PeerId> connected_;    ///< of these, ascending
  std::vector<PeerId> newcomers_;    ///< of these, who have not been greeted
  bool has_sent_ = false;
  std::vector<std::uint8_t> jointed_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_;  ///< slots of bodies that move
  /// By slot, what acts on bodies: Springs::Grip, kTouched and the like.
  std::vector<std::uint8_t> acting_;
  std::vector<std::uint8_t> touching_;
  /// Slots of a body and of what pushed it in the last step of another engine.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> noted_contacts_;
  std::vector<std::pair<PeerId, std::size_t>> owners_;  ///< by id, with the number of their bodies
  SessionTime now_ = 0;
  SessionTime started_ = 0;
  SessionTime last_before_ = 0;
  SessionTime next_send_ = 0;
  double step_dt_ = 1.0 / 60.0;
  pbd::TargetMotion motion_ = pbd::TargetMotion::WithBody;  ///< of estimates_
  bool apart_ = false;                                      ///< something is to be replayed for

  // Scratch, kept for its capacity.
  std::vector<Packet> packets_;
  std::vector<PeerStatus> senders_;  ///< of packets_, where any is dated on receipt
  DecodedPacket incoming_;
  struct Decoded {
    const Packet* packet = nullptr;
    DecodedPacket content;
  };
  /// So many are decoded before they are looked at: a reading of the processor's clock, for each of
  /// the two, costs as much as a state (benchmarks/network/receive_cost).
  std::array<Decoded, 16> batch_;
  std::vector<PeerEstimate> estimates_;
  std::vector<Stamped> stamped_;  ///< of estimates_
  std::vector<Wanted> wanted_;
  std::vector<Claim> claims_;  ///< of the body that estimate() was asked about
  std::vector<Claim> turns_;
  std::vector<PeerId> leaders_;
  std::vector<std::uint32_t> assembly_;  ///< slots of bodies that are placed together
  std::vector<std::uint32_t> island_;    ///< and of those that touch them
  std::vector<Vote> votes_;
  std::vector<Springs::Hand> hands_;
  std::vector<pbd::PoseTarget> targets_;
  std::vector<Shared*> targeted_;  ///< of targets_
  std::vector<StateUpdate> states_;
  std::vector<StateUpdate> concerning_;
  std::vector<UnknownState> unknown_;
  std::vector<SpringUpdate> spring_states_;
  std::vector<SpringUpdate> spring_events_;
  std::vector<std::byte> outgoing_;
  AnchorMessages anchors_;
  StateUpdate meant_;
  std::vector<OutgoingState> selectable_;
  std::vector<SpringUpdate> told_in_full_;
};

}  // namespace tandem::consensus
