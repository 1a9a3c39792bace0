# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Cross-built static libraries are installed with what they need: FCL, libccd and tinyobjloader as they were
# compiled with Tandem (tandem_module), libsodium and Eigen's headers from the sysroot and the system, and what
# their licences ask for. Shared libraries have all of it inside but Eigen; DLLs come with its headers and with
# the compiler's DLLs, as Windows has no packages for them.
set(TANDEM_BUNDLE OFF)
if(NOT TANDEM_SYSROOT)
  return()
endif()
if(NOT BUILD_SHARED_LIBS OR WIN32)
  set(TANDEM_BUNDLE ON)
  get_target_property(folders Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  install(DIRECTORY "${folders}/Eigen" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/eigen3" COMPONENT dev)
  # find_package takes the user's Eigen where there is one; pkg-config finds this one beside Tandem's files.
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/eigen3.pc" @ONLY CONTENT
"prefix=\${pcfiledir}/../..
Name: eigen3
Description: Eigen's headers
Version: ${Eigen3_VERSION}
Cflags: -I\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}/eigen3
")
  install(FILES "${PROJECT_BINARY_DIR}/eigen3.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT dev)
  if(TANDEM_NET_UDP AND NOT BUILD_SHARED_LIBS)
    find_library(TANDEM_SODIUM_ARCHIVE NAMES libsodium.a PATHS "${TANDEM_SYSROOT}/lib"
                 NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH REQUIRED)
    mark_as_advanced(TANDEM_SODIUM_ARCHIVE)
    set(archive "${CMAKE_INSTALL_LIBDIR}/libtandem_sodium.a")
    install(FILES "${TANDEM_SODIUM_ARCHIVE}" DESTINATION "${CMAKE_INSTALL_LIBDIR}"
            RENAME libtandem_sodium.a COMPONENT dev)
    add_library(tandem_sodium INTERFACE)
    set_target_properties(tandem_sodium PROPERTIES EXPORT_NAME sodium)
    target_link_libraries(tandem_sodium INTERFACE
      "$<BUILD_INTERFACE:PkgConfig::SODIUM>" "$<INSTALL_INTERFACE:$<INSTALL_PREFIX>/${archive}>")
  endif()
endif()
if(WIN32 AND BUILD_SHARED_LIBS)
  foreach(library IN ITEMS libstdc++-6 libgcc_s_seh-1 libwinpthread-1)
    execute_process(COMMAND "${CMAKE_CXX_COMPILER}" -print-file-name=${library}.dll OUTPUT_VARIABLE file
                    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    install(FILES "${file}" DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT runtime)
  endforeach()
endif()

# Parts of other projects in the archives and programs, with their licences from Debian.
set(packages libfcl-dev libccd-dev libsodium-dev libeigen3-dev libxsimd-dev libasio-dev
  libtinyobjloader-dev nlohmann-json3-dev libtomlplusplus-dev libtinygltf-dev)
if(WIN32)
  list(APPEND packages mingw-w64-x86-64-dev g++-mingw-w64-x86-64-posix)
endif()
set(component license)
set(documents tandem)
if(BUILD_SHARED_LIBS AND NOT WIN32)
  # In Debian's package of the libraries, and under its name.
  set(component runtime)
  set(documents libtandem${tandem_abi})
endif()
foreach(package IN LISTS packages)
  install(FILES "/usr/share/doc/${package}/copyright" COMPONENT ${component} OPTIONAL
          DESTINATION "${CMAKE_INSTALL_DATAROOTDIR}/doc/${documents}/licenses" RENAME "${package}.txt")
endforeach()
