// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/export.h"

/// Elementary functions that give the same bits on every machine. Those of the C library differ in
/// the last bit from one library to the next, and a simulation makes metres of that. Whatever a
/// step computes calls these; what IEEE 754 defines to the bit (sqrt, floor, fmod) needs no others.
///
/// Errors are in units in the last place of the result (ulp), in the default rounding; infinities
/// and NaN are as in C. Method: [muller2016] Sec. 11.2 (Cody and Waite's reduction), then Taylor
/// series, whose coefficients are known and whose remainders are below 1/8 ulp.
/// @par Thread safety  All are safe.
namespace tandem::pbd::portable {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// @param angle  rad. Below 1e6 in size the error is less than 1.1 ulp; from there on, the angle is
/// taken modulo
///               the double next to 2 pi, which is off by 4e-17 of it.
TANDEM_API SinCos sin_cos(double angle);

/// Angle (rad, -pi to pi) of the point (x, y) from the x axis; 0 of the origin. Less than 2 ulp.
TANDEM_API double atan2(double y, double x);

/// e^x. Less than 1 ulp where the result is a normal number.
TANDEM_API double exp(double x);

/// e^x - 1. Less than 2 ulp.
TANDEM_API double expm1(double x);

/// ln(1 + x). Less than 2 ulp.
TANDEM_API double log1p(double x);

/// Length of (x, y). Less than 2 ulp where the squares neither overflow nor vanish: 1e-150 to
/// 1e150.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace tandem::pbd::portable
