// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Texts of --help, and names of options in results.
#include <string>
#include <string_view>

#include "session/options.h"

namespace tandem::demos {

std::string usage(std::string_view program) {
  const std::string name(program);
  return "usage: " + name + R"( [options]

  --profile 0..5     how far apart: 0, 3.5, 6, 28.5, 63.5 or 123.5 ms one way (3)
  --seconds S        length (20)
  --coupling A[,B]   how copies are kept together: one-pass (Tandem's), two-step-paper, single-owner
                     or none; beside B
  --view             see it and touch it in a browser
  --print details    all measures in place of the summary in words
  --json FILE        the result for programs; - is standard output
  --record FILE.glb  all motion, for any viewer of glTF
  --listen PORT, --connect HOST:PORT   two processes over a network, see --help-all
  --help-all         all options

for example:
  )" + name +
         R"( --profile 5                 across an ocean
  )" + name +
         R"( --coupling none             without agreement
  )" + name +
         R"( --view --profile 4          touch it while it runs
  )" + name +
         R"( --listen 7777               and in another terminal:
  )" + name +
         R"( --connect localhost:7777
)";
}

std::string usage_of_all(std::string_view program) {
  return "usage: " + std::string(program) + R"( [options]
All peers in one process, in virtual time (the default):
  --peers N          peers, 1 to 64 (2)
  --profile 0..5     link: 0, 3.5, 6, 28.5, 63.5 or 123.5 ms one way (3)
  --link KEY=VALUE,..  chances per state of loss, duplicate, reorder (0); bandwidth in bit/s in
                     each direction (0 = unlimited); max-state, bytes of the longest packet: 502 is
                     an MTU of 576 (65536); network, of the second peer: wifi, which
                     stalls for up to 2 s, swollen, a buffer of 1 s, lopsided, 200 ms there and
                     20 ms back, or bursts of loss
One peer per process, in wall time; without --key on this machine alone:
  --listen PORT      accept peers here; 0 takes a free port
  --connect HOST:PORT  call a peer; may be repeated; one of a mesh is enough
  --peer-id N        unique in the session (1 with --listen alone, else 2)
  --key FILE         encrypted; 64 hex digits, the same for all (tandem-key makes one)
  --transport tcp|udp  (udp with --key, else tcp)
  --wait S           give up if no peer has come after S seconds (0 = never)
Session:
  --seconds S        length (20)
  --seed N           of all random numbers (1)
  --clock session|system|none   over UDP: time agreed on in the session, the system clock, if
                     disciplined by PTP or NTP, or each peer's own: updates are dated on receipt
                     (session); in virtual time only none, spread=S between the clocks of
                     successive peers, and off-grid: peers step at their own times instead of
                     multiples of the session's step
  --influence X      baseline share per 1/60 s, 0 to 0.99; 0 = no agreement (0.08)
  --coupling A[,B]   one-pass, two-step, two-step-paper, single-owner or none (one-pass); beside B,
                     one of them or nothing (as the scene proposes; nothing for results for
                     programs, or if A was chosen)
  --mode soft|asymmetric|hard      how the other peers treat users' springs (soft)
  --predictor none|euler|replay
                     (replay; euler with two-step-paper and single-owner)
  --agreement KEY=VALUE,..  share of the gap to the replayed mean that is closed per 1/60 s, above 0
                     to 1 (0.25); budget, replayed steps per step, 1 to 1000 (4; 1000 = a new replay
                     in each); inputs=known|common, users' springs in a replay (known)
  --send KEY=VALUE,..  hz, states per second (60); compact, states rounded to few bits; budget in
                     kbit/s to each other peer, headers included (0 = unlimited; over UDP 2000);
                     tolerance in m: states that the others predict so well are not sent (0);
                     near in m: send only bodies near the receiver's user or held (0 = all)
  --rates F,F,..     steps per second of the peers, in turn (60)
  --engines E,E,..   tandem or bullet, of the peers, in turn (tandem); bullet takes two steps
  --substeps N       of Tandem's solver (4)
  --iterations N[,M]  sweeps of Tandem's pass in each substep (1), and of Bullet's solver (10)
  --ablate PART,..   omit parts to see their effect: channels, velocities, initiative, leading
  --variant NAME     of the scenario, if it has any
  --view [[ADDRESS:]PORT]  serve a page that shows the run, until ctrl-c unless --seconds is given;
                     its address is printed (docs/view.md); on this machine alone unless a numeric
                     address is given
  --script FILE|none|hands=FILE,..  users replay inputs of --record instead of their script;
                     none: only users at the page act; hands=: users' hands replay records of a
                     room's page, user A's the first file and so on; users without a file follow
                     the script (docs/hands.md)
Output:
  --json FILE        write the result as one JSON object; - is standard output
  --csv DIR          write tables of all samples and of all bodies
  --record FILE      write the users' inputs in each step; FILE.glb: all motion, as glTF 2.0
  --trace FILE       write all input of a peer, for tandem-replay; FILE.1, FILE.2, .. if all
                     peers are in one process
  --print nothing|story|details  not even a progress bar, a summary in words, or all measures
                     (story)
  --reference        also run the same inputs at one peer, and compare
  --help, -h         common options, with examples; --help-all: this text
  --version          of this program
)";
}

std::string_view to_string(consensus::PredictorKind kind) {
  switch (kind) {
    case consensus::PredictorKind::None:
      return "none";
    case consensus::PredictorKind::Euler:
      return "euler";
    case consensus::PredictorKind::Replay:
      break;
  }
  return "replay";
}

std::string_view to_string(consensus::InputMode mode) {
  if (mode == consensus::InputMode::Soft) return "soft";
  return mode == consensus::InputMode::Hard ? "hard" : "asymmetric";
}

std::string_view to_string(Scheme scheme) {
  switch (scheme) {
    case Scheme::OnePass:
      return "one-pass";
    case Scheme::TwoStepPaper:
      return "two-step-paper";
    case Scheme::TwoStep:
      return "two-step";
    case Scheme::None:
      return "none";
    case Scheme::SingleOwner:
      break;
  }
  return "single-owner";
}

}  // namespace tandem::demos
