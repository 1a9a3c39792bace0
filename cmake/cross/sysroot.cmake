# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What the toolchain files have in common: libraries and headers are those of cmake/cross/sysroot.sh, also where a
# build configures itself again without the preset's environment.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
if(TANDEM_SYSROOT)
  set(ENV{PKG_CONFIG_LIBDIR} "${TANDEM_SYSROOT}/lib/pkgconfig")
endif()
