// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/export.h"

/// Elementary functions with the same bits on every machine. C libraries differ in the last bit,
/// which a simulation amplifies to metres. Every step computes with these; operations that IEEE 754
/// defines to the bit (sqrt, floor, fmod) need no replacement.
///
/// Errors are in units in the last place of the result (ulp), in the default rounding; infinities
/// and NaN are as in C. Method: [muller2016] Sec. 11.2 (Cody and Waite's reduction), then Taylor
/// series with exact coefficients and remainders below 1/8 ulp.
/// @par Thread safety  All are safe.
namespace tandem::pbd::portable {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// @param angle  rad. The error is below 1.1 ulp for |angle| < 1e6; larger angles are reduced
///   modulo the double next to 2 pi, which is off by 4e-17 of it.
TANDEM_API SinCos sin_cos(double angle);

/// Angle (rad, -pi to pi) of the point (x, y) from the x axis; 0 at the origin. Less than 2 ulp.
TANDEM_API double atan2(double y, double x);

/// e^x. Less than 1 ulp if the result is a normal number.
TANDEM_API double exp(double x);

/// e^x - 1. Less than 2 ulp.
TANDEM_API double expm1(double x);

/// ln(1 + x). Less than 2 ulp.
TANDEM_API double log1p(double x);

/// Length of (x, y). Less than 2 ulp from 1e-150 to 1e150, where squares neither overflow nor
/// underflow.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace tandem::pbd::portable
