// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Operations on rows, A::size of them at once.
#pragma once

#include "contact_blow.h"
#include "contact_push.h"
#include "contact_solve.h"

namespace tandem::pbd::kernel {

/// Calls `visit.operator()<B>(at)` for the batches with these lanes.
/// @tparam Half  used for lanes that lie in one half of a batch
template <class A, class Half, class Visit>
void for_batches(LaneMask lanes, Visit&& visit) {
  constexpr std::size_t half = kLanes / 2;
  constexpr LaneMask low = (1u << half) - 1u;
  const bool first = (lanes & low) != 0;
  const bool second = (lanes & ~low) != 0;
  if (xsimd::batch<double, A>::size == kLanes && first && second) {
    visit.template operator()<A>(std::size_t{0});
    return;
  }
  if (first) visit.template operator()<Half>(std::size_t{0});
  if (second) visit.template operator()<Half>(half);
}

template <class A, class Half, bool holds>
LaneMask push_all(const ContactRows& rows, LaneMask asked, BodyNumbers bodies) {
  unsigned acted = 0;
  for_batches<A, Half>(asked & lanes_in_use(rows), [&]<class B>(std::size_t at) {
    acted |= rows.faces ? push<B, true, holds>(rows, at, asked, bodies)
                        : push<B, false, holds>(rows, at, asked, bodies);
  });
  return static_cast<LaneMask>(acted);
}

template <class A, class Half>
constexpr ContactKernels kernels() {
  static_assert(xsimd::batch<double, Half>::size == kLanes / 2);
  ContactKernels out;
  out.prepare = [](ContactRows& rows, LaneMask asked, BodyNumbers bodies) {
    for_batches<A, Half>(asked & lanes_in_use(rows), [&]<class B>(std::size_t at) {
      if (asked == kAllLanes) {
        rows.faces ? prepare<B, true, true>(rows, at, asked, bodies)
                   : prepare<B, false, true>(rows, at, asked, bodies);
      } else {
        rows.faces ? prepare<B, true, false>(rows, at, asked, bodies)
                   : prepare<B, false, false>(rows, at, asked, bodies);
      }
    });
  };
  out.begin = [](ContactRows& rows, const SubstepRule& rule, BodyNumbers bodies,
                 AnchorNumbers anchors) {
    rows.penetrating = 0;
    rows.bounces = false;
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      const Begun begun = rows.faces ? begin<B, true>(rows, at, rule, bodies, anchors)
                                     : begin<B, false>(rows, at, rule, bodies, anchors);
      rows.penetrating = static_cast<LaneMask>(rows.penetrating | begun.penetrating);
      rows.bounces = rows.bounces || begun.bounces;
    });
  };
  out.warm_start = [](const ContactRows& rows, BodyNumbers bodies) {
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      rows.faces ? warm_start<B, true>(rows, at, bodies) : warm_start<B, false>(rows, at, bodies);
    });
  };
  out.solve = [](ContactRows& rows, ContactPass pass, int iterations, LaneMask asked,
                 BodyNumbers bodies) {
    for_batches<A, Half>(asked & lanes_in_use(rows), [&]<class B>(std::size_t at) {
      rows.faces ? solve_faces<B>(rows, at, pass, iterations, asked, bodies)
                 : solve_points<B>(rows, at, pass, iterations, asked, bodies);
    });
  };
  out.push = push_all<A, Half, false>;
  out.hold = push_all<A, Half, true>;
  out.meet = [](const ContactRows& rows, Blow& blow, double slow, bool first, BodyNumbers bodies) {
    unsigned hit = 0;
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      hit |= rows.faces ? meet<B, true>(rows, blow, at, slow, first, bodies)
                        : meet<B, false>(rows, blow, at, slow, first, bodies);
    });
    return static_cast<LaneMask>(hit & lanes_in_use(rows));
  };
  out.strike = [](const ContactRows& rows, Blow& blow, LaneMask asked, BodyNumbers bodies) {
    blow.change = {};
    for_batches<A, Half>(asked, [&]<class B>(std::size_t at) {
      rows.faces ? strike<B, true>(rows, blow, at, asked, bodies)
                 : strike<B, false>(rows, blow, at, asked, bodies);
    });
  };
  out.settle = [](ContactRows& rows, const Blow& blow, BodyNumbers bodies) {
    for_batches<A, Half>(blow.struck, [&]<class B>(std::size_t at) {
      rows.faces ? settle<B, true>(rows, blow, at, bodies)
                 : settle<B, false>(rows, blow, at, bodies);
    });
    rows.bounces = true;
  };
  return out;
}

}  // namespace tandem::pbd::kernel
