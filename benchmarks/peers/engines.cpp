// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peers/engines.h"

namespace tandem::bench {

std::vector<std::pair<std::string, MakeEngine>> built_engines() {
  return {
      {"tandem", make_tandem},
#ifdef TANDEM_BENCH_BULLET64
      {"bullet64", make_bullet},
#endif
#ifdef TANDEM_BENCH_JOLT
      {"jolt", make_jolt},
#endif
#ifdef TANDEM_BENCH_BOX3D
      {"box3d", make_box3d},
#endif
#ifdef TANDEM_BENCH_PHYSX
      {"physx_pgs", make_physx_pgs}, {"physx_tgs", make_physx_tgs},
#endif
  };
}

}  // namespace tandem::bench
