// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Choice of a contact's direction, common to two boxes (box_box.cpp) and any two convex cores
// (convex_manifold.cpp).
#pragma once

namespace tandem::collision {

/// A face is taken if its separation is within this share of the depth ...
inline constexpr double kFaceShare = 0.05;
/// ... or within this share of the smaller part's size of the best. For bodies without radius only:
/// round ones touch at one point, whose direction is exact.
inline constexpr double kFaceSize = 5e-4;

/// Cosine between the normals of an edge contact and a face above which the face is used, if the
/// overlap over it is no deeper. For two long crossing bars that are tilted imperceptibly, edges
/// separate better than whole faces: held at one of the four places where their edges cross, a
/// tower of 60 bars dropped by 5 % of their height went through itself.
inline constexpr double kAlongside = 0.95;

/// Share of the smaller part's size by which two boxes must overlap perpendicular to the direction
/// in which they are apart.
inline constexpr double kPassBy = 5e-3;
/// Cosine above which two directions count as one for that.
inline constexpr double kAcross = 0.9;

}  // namespace tandem::collision
