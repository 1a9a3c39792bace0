# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Headers alone, from the folder of cmake/cross/sysroot.sh.
if(NOT TARGET Boost::headers)
  add_library(Boost::headers INTERFACE IMPORTED GLOBAL)
  target_include_directories(Boost::headers INTERFACE "${TANDEM_SYSROOT}/include")
  # Boost 1.74 asks for std::result_of elsewhere, which libc++ has in C++20 no more.
  target_compile_definitions(Boost::headers INTERFACE BOOST_ASIO_HAS_STD_INVOKE_RESULT)
endif()
set(Boost_FOUND ON)
