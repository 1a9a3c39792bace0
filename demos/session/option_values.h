// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "session/ablation.h"
#include "session/options.h"
#include "session/physics.h"
#include "tandem/consensus/peer.h"

// Parsers of option values. All throw UsageError.
namespace tandem::demos {

/// A limit: 0 for none, or a number from `least` to `most`.
double limit(std::string_view option, std::string_view text, double least, double most,
             std::string_view rule);
consensus::PredictorKind predictor(std::string_view text);
consensus::InputMode mode(std::string_view text);
Scheme scheme(std::string_view option, std::string_view text);
Print print(std::string_view text);
/// "HOST:PORT"
std::string address(std::string_view text);
/// "60,72": steps per second of the peers, cyclically.
std::vector<double> rates(std::string_view text);
/// "tandem,bullet": engines of the peers, cyclically.
std::vector<Engine> engines(std::string_view text);
/// "channels,velocities": parts to omit.
Ablation ablation(std::string_view text);

}  // namespace tandem::demos
