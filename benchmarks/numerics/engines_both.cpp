// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "numerics/engines.h"

namespace tandem::bench {

std::vector<std::pair<std::string, MakeEngine>> numerics_engines() {
  return {{"tandem", make_tandem}, {"bullet64", make_bullet}};
}

}  // namespace tandem::bench
