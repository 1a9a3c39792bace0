# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For Windows with Debian's g++-mingw-w64-x86-64-posix; what is built runs on wine. Static builds need none of the
# compiler's libraries. With DLLs all share one C++ library, so that exceptions pass between them.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
if(NOT BUILD_SHARED_LIBS)
  set(CMAKE_EXE_LINKER_FLAGS_INIT -static)
endif()
set(CMAKE_CROSSCOMPILING_EMULATOR wine)
include("${CMAKE_CURRENT_LIST_DIR}/sysroot.cmake")
