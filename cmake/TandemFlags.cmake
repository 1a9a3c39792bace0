# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# House flags, for every target of this tree and for no target of a project that includes it.

# Results are part of the contract between peers: no fused multiply-add that the source did not ask
# for, whatever the machine.
add_compile_options(-ffp-contract=off)
# Eigen asks for it on ARM, in products of matrices, where the compiler says that there is one.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64|ARM64)$")
  add_compile_options(-U__ARM_FEATURE_FMA)
endif()
add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion)
# Structs of one source file are also written so, and need no defaults; those in public headers have
# them (tests/package/designated.py).
add_compile_options(-Wno-missing-field-initializers)
if(WIN32)
  # Windows 10 on; its headers define fewer macros over common names; numbers are printed as C99 has it.
  add_compile_definitions(_WIN32_WINNT=0x0A00 NOMINMAX WIN32_LEAN_AND_MEAN __USE_MINGW_ANSI_STDIO=1)
endif()
if(TANDEM_WERROR)
  add_compile_options(-Werror)
elseif(NOT PROJECT_IS_TOP_LEVEL)
  # That of a project around it is meant for its own sources.
  add_compile_options(-Wno-error)
  set(CMAKE_COMPILE_WARNING_AS_ERROR OFF)
endif()

if(TANDEM_SANITIZE)
  list(JOIN TANDEM_SANITIZE "," _tandem_sanitize)
  add_compile_options(-fsanitize=${_tandem_sanitize} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer)
  # Reports name lines and no variables: full tables make the build a third longer.
  add_compile_options(-g1)
  # Instrumented code sends this one astray, inside the standard library too.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${_tandem_sanitize})
  unset(_tandem_sanitize)
endif()
