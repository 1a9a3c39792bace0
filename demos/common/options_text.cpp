// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What --help says, and what options are called in results.
#include <string>
#include <string_view>

#include "common/options.h"

namespace tandem::demos {

std::string usage(std::string_view program) {
  return "usage: " + std::string(program) + R"( [options]
All peers in one process, in virtual time (the default):
  --peers N          peers, 1 to 64 (2)
  --profile 0..5     link: 0, 3.5, 6, 28.5, 63.5 or 123.5 ms one way (3)
  --loss P --duplicate P --reorder P   chances for each state on the link (0)
  --bandwidth B      of the link, bit/s in each direction (0 = unlimited)
  --clock-spread S   from one peer's clock to the next one's; with --clock none it does not matter
                     (0)
  --phases session|random          when peers step: at multiples of the step of the session's time, or
                     each in between at a time of its own, as it is with --clock none (session)
  --max-state N      bytes of the longest packet of states; 502 is an MTU of 576 (65536)
One peer for each process, in wall time; on this machine alone where there is no --key:
  --listen PORT      accept peers here; 0 takes a free port
  --connect HOST:PORT  call a peer; may be repeated; one of a mesh is enough
  --peer-id N        unique in the session (1 with --listen alone, else 2)
  --key FILE         encrypted; 64 hex digits, the same for all (tandem-key makes one)
  --insecure         UDP without a secret; loopback addresses only
  --transport tcp|udp  (udp with --key or --insecure, else tcp)
  --clock session|system|none   over UDP: time agreed on in the session, the system clock, where
                     PTP or NTP disciplines it, or each its own: what comes is dated on receipt
                     (session); in virtual time none alone
  --wait S           give up where nobody has come after S seconds (0 = never)
Session:
  --seconds S        length (20)
  --seed N           of everything that is drawn (1)
  --influence X      baseline share per 1/60 s, 0 to 0.99; 0 = no agreement (0.08)
  --coupling one-pass|one-pass-plain|two-step|two-step-plain|two-step-paper|single-owner|pd|none
                     (one-pass)
  --pd-frequency F   Hz, natural frequency of pd's spring (0.5)
  --mode soft|asymmetric|hard      what users' springs are to the others (soft)
  --predictor none|euler|second-order|replay
                     (replay; euler with plain, paper, single-owner and pd)
  --closing-share S  of the gap to the replayed mean, per 1/60 s, above 0 to 1 (0.2)
  --inputs known|common            of users' springs, what a replay knows (known)
  --replay-budget N  steps replayed for each step, 1 to 1000; 1000 = a new replay each step (4)
  --replay-substeps N              of a replayed step; 0 = as the world's own (0)
  --extrapolation S  longest extrapolation of states (1)
  --spring-extrapolation S         of users' springs; 0 = off (0.3)
  --compact          states rounded to few bits
  --budget K         kbit/s that a peer sends to each other one, headers included (0 = unlimited;
                     over UDP 2000)
  --tolerance M      states that the others expect nearly right are not sent (0 = all are)
  --update-hz F      states sent each second (60)
  --rates F,F,..     steps each second of the peers, in turn (60)
  --engines E,E,..   tandem or bullet, of the peers, in turn (tandem); bullet takes two steps
  --bullet-iterations N            of Bullet's solver (10)
  --substeps N       of Tandem's solver (4)
  --iterations N     sweeps of its pass in each substep (1)
  --ablate PART,..   do without, to see what it is worth: channels, velocities, motion, total,
                     masses, rotation, age, initiative, leading, arbitration,
                     ramp, refine
  --uneven           the same as --rates 60,72
  --variant NAME     of the scenario, where it has any
  --view [PORT]      serve a page that shows the run, until ctrl-c unless --seconds is given; its
                     address is printed (docs/view.md)
  --view-address A   serve it at this address, numeric (127.0.0.1: to this machine alone)
  --no-script        nobody acts but who grabs something on the page
  --replay FILE      users do what --record wrote, instead of following their script
Output:
  --json FILE        write the result as one JSON object; - is standard output
  --csv DIR          write tables of all samples and of all bodies
  --record FILE      write what the users did in each step; FILE.glb: all motion, as glTF 2.0
  --trace FILE       write all that enters a peer, for tandem-replay; FILE.1, FILE.2, .. where all
                     peers are in one process
  --reference        run what the users did at one peer as well, and compare
  --quiet            no table and no progress bar
  --help             this text
)";
}

std::string_view to_string(consensus::PredictorKind kind) {
  switch (kind) {
    case consensus::PredictorKind::None:
      return "none";
    case consensus::PredictorKind::Euler:
      return "euler";
    case consensus::PredictorKind::SecondOrder:
      return "second-order";
    case consensus::PredictorKind::Replay:
      break;
  }
  return "replay";
}

std::string_view to_string(consensus::ReplayInputs inputs) {
  return inputs == consensus::ReplayInputs::Common ? "common" : "known";
}

std::string_view to_string(consensus::InputMode mode) {
  if (mode == consensus::InputMode::Soft) return "soft";
  return mode == consensus::InputMode::Hard ? "hard" : "asymmetric";
}

std::string_view to_string(Scheme scheme) {
  switch (scheme) {
    case Scheme::OnePass:
      return "one-pass";
    case Scheme::OnePassPlain:
      return "one-pass-plain";
    case Scheme::TwoStepPaper:
      return "two-step-paper";
    case Scheme::TwoStepPlain:
      return "two-step-plain";
    case Scheme::TwoStep:
      return "two-step";
    case Scheme::None:
      return "none";
    case Scheme::SingleOwner:
      return "single-owner";
    case Scheme::Pd:
      break;
  }
  return "pd";
}

}  // namespace tandem::demos
