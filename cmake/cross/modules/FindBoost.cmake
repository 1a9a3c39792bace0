# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Headers alone, from the folder of cmake/cross/sysroot.sh.
if(NOT TARGET Boost::headers)
  add_library(Boost::headers INTERFACE IMPORTED GLOBAL)
  target_include_directories(Boost::headers INTERFACE "${TANDEM_SYSROOT}/include")
endif()
set(Boost_FOUND ON)
