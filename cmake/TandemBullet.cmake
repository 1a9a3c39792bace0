# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Bullet, which benchmarks and demos may use and no module does. Debian ships it in single and in
# double precision: PkgConfig::BULLET32, PkgConfig::BULLET64, where BULLET32_FOUND, BULLET64_FOUND.
include_guard(GLOBAL)

find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(BULLET32 QUIET IMPORTED_TARGET GLOBAL bullet)
  pkg_check_modules(BULLET64 QUIET IMPORTED_TARGET GLOBAL bullet-float64)
endif()
