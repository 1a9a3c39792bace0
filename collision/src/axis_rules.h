// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Which direction a contact takes: the same for two boxes, in box_box.cpp, as for any two convex
// cores, in convex_manifold.cpp.
#pragma once

namespace tandem::collision {

/// A face is taken where its separation is within this share of the depth ...
inline constexpr double kFaceShare = 0.05;
/// ... or within this share of the smaller part's size of the best. Bodies without radius only:
/// round ones touch at one point, whose direction is exact.
inline constexpr double kFaceSize = 5e-4;

/// Cosine between the normals of an edge contact and of a face above which the face serves, where
/// what lies over it is no deeper. Two long bars that cross are tilted by less than the eye sees,
/// and yet edges part them better than the planes of whole faces do: held at one of the four places
/// where their edges cross, a tower of 60 bars dropped by 5 % of their height went through itself.
inline constexpr double kAlongside = 0.95;

/// Share of the smaller part's size by which two boxes must overlap beside the direction in which
/// they are apart.
inline constexpr double kPassBy = 5e-3;
/// Cosine between two directions above which they count as one for that.
inline constexpr double kAcross = 0.9;

}  // namespace tandem::collision
