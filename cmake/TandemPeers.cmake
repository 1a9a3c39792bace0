# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Engines that benchmarks compare with. Bullet comes from Debian; of the others users name what
# `cmake --install` of their own build has written, and what is not named is left out. How each of
# them is built stands in benchmarks/peers/README.md.
#   TANDEM_JOLT_DIR, TANDEM_BOX3D_DIR, TANDEM_PHYSX_DIR -> Jolt::Jolt, box3d::box3d, physx::physx
include_guard(GLOBAL)
include(TandemBullet)

set(TANDEM_JOLT_DIR "" CACHE PATH "Prefix of an installed Jolt, to compare with; empty: without")
set(TANDEM_BOX3D_DIR "" CACHE PATH "Prefix of an installed Box3D, to compare with; empty: without")
set(TANDEM_PHYSX_DIR "" CACHE PATH "Prefix of an installed PhysX, to compare with; empty: without")

if(TANDEM_JOLT_DIR)
  find_package(Jolt CONFIG REQUIRED PATHS "${TANDEM_JOLT_DIR}" NO_DEFAULT_PATH)
endif()
if(TANDEM_BOX3D_DIR)
  find_package(box3d CONFIG REQUIRED PATHS "${TANDEM_BOX3D_DIR}" NO_DEFAULT_PATH)
endif()
if(TANDEM_PHYSX_DIR)
  # PhysX brings no package for CMake; its libraries lie where its own scripts put them.
  find_path(TANDEM_PHYSX_INCLUDE PxPhysicsAPI.h
    PATHS "${TANDEM_PHYSX_DIR}/include" NO_DEFAULT_PATH NO_CACHE REQUIRED)
  add_library(physx::physx INTERFACE IMPORTED)
  target_include_directories(physx::physx INTERFACE "${TANDEM_PHYSX_INCLUDE}")
  target_compile_definitions(physx::physx INTERFACE NDEBUG)  # as its libraries were built
  foreach(part IN ITEMS Extensions "" PvdSDK Cooking Common Foundation)
    find_library(library NAMES PhysX${part}_static_64 PhysX${part}_static
      PATHS "${TANDEM_PHYSX_DIR}/bin/linux.x86_64/release"
            "${TANDEM_PHYSX_DIR}/bin/linux.aarch64/release"
      NO_DEFAULT_PATH NO_CACHE REQUIRED)
    target_link_libraries(physx::physx INTERFACE "${library}")
    unset(library)
  endforeach()
  find_package(Threads REQUIRED)
  target_link_libraries(physx::physx INTERFACE Threads::Threads ${CMAKE_DL_LIBS})
endif()
