# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For this machine with clang and libc++: what is in C++ is built with Tandem, as for another system.
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_CXX_FLAGS_INIT -stdlib=libc++)
if(TANDEM_SYSROOT)
  set(ENV{PKG_CONFIG_PATH} "${TANDEM_SYSROOT}/lib/pkgconfig")
endif()
