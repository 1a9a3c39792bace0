# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For this machine with clang and libc++: what is in C++ is built with Tandem, as for another system.
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_CXX_FLAGS_INIT -stdlib=libc++)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
if(TANDEM_SYSROOT)
  set(ENV{PKG_CONFIG_LIBDIR} "${TANDEM_SYSROOT}/lib/pkgconfig")
endif()
