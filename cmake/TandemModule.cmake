# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# One function for each kind of target. Files are listed by the caller, never globbed.

function(_tandem_common target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES
    CXX_EXTENSIONS OFF
    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
endfunction()

# Of shared libraries: the part of the version that binary compatibility goes by. Before 1.0 each
# minor version may break it, from then on each major one.
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(tandem_abi "0.${PROJECT_VERSION_MINOR}")
else()
  set(tandem_abi "${PROJECT_VERSION_MAJOR}")
endif()
configure_file("${CMAKE_CURRENT_LIST_DIR}/exports.map.in" "${PROJECT_BINARY_DIR}/exports.map" @ONLY)

# tandem_module(<name> SOURCES ... [PUBLIC_LINK ...] [PRIVATE_LINK ...] [ABSENT_HEADERS ...])
#
# A library of the product: target tandem_<name>, alias tandem::<name>, public headers in
# include/tandem/<namespace>/, where the namespace has its name unless it adds to another's; what puts
# modules together is in namespace tandem and in include/tandem/. It is
# installed with an export set of its own, so that a consumer of one module needs the dependencies of
# that module only. ABSENT_HEADERS, by their file names, belong to something that this build leaves
# out: they are not installed. One without a folder include has its declarations in another's headers.
function(tandem_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC_LINK;PRIVATE_LINK;ABSENT_HEADERS")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tandem_module(${name}): unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set(target tandem_${name})
  add_library(${target} ${arg_SOURCES})
  add_library(tandem::${name} ALIAS ${target})
  _tandem_common(${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name}
    POSITION_INDEPENDENT_CODE ON
    VERSION ${PROJECT_VERSION}
    SOVERSION ${tandem_abi})
  if(BUILD_SHARED_LIBS)
    _tandem_shared(${target})
  endif()
  target_include_directories(${target}
    PUBLIC "$<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>"
           "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>"
    PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/src")
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC_LINK})
  foreach(dependency IN LISTS arg_PRIVATE_LINK)
    # A header-only dependency leaves nothing for a consumer's linker, so the installed package
    # does not mention it: tandem::net is used without Asio's headers.
    get_target_property(bundled ${dependency} TANDEM_BUNDLED)
    if(bundled)
      # Compiled with Tandem, as the system has none: static libraries are installed with it.
      target_link_libraries(${target} PRIVATE ${bundled})
      if(NOT BUILD_SHARED_LIBS)
        install(TARGETS ${bundled} EXPORT tandem-${name}-targets ARCHIVE COMPONENT dev)
      endif()
      continue()
    endif()
    get_target_property(type ${dependency} TYPE)
    get_target_property(libraries ${dependency} INTERFACE_LINK_LIBRARIES)
    if(type STREQUAL "INTERFACE_LIBRARY" AND NOT libraries)
      target_link_libraries(${target} PRIVATE "$<BUILD_INTERFACE:${dependency}>")
    else()
      target_link_libraries(${target} PRIVATE ${dependency})
    endif()
  endforeach()

  install(TARGETS ${target} EXPORT tandem-${name}-targets
    RUNTIME COMPONENT runtime
    LIBRARY COMPONENT runtime NAMELINK_COMPONENT dev
    ARCHIVE COMPONENT dev)
  set(absent)
  foreach(header IN LISTS arg_ABSENT_HEADERS)
    list(APPEND absent PATTERN "${header}" EXCLUDE)
  endforeach()
  if(IS_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}/include")
    install(DIRECTORY include/ DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT dev FILES_MATCHING
            PATTERN "*.h" ${absent})
  endif()
  install(EXPORT tandem-${name}-targets NAMESPACE tandem::
          DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/tandem" COMPONENT dev)

  if(TANDEM_BUILD_TESTS AND TANDEM_CHECK_HEADERS)
    _tandem_header_check(${name})
  endif()
endfunction()

# A shared library shows what is marked TANDEM_API and nothing else, wants nothing that it does not
# name, and finds its kin beside it.
function(_tandem_shared target)
  if(WIN32)
    # DLLs export what is marked and not inline: inline members of marked classes are compiled into each
    # user, so a module does not export those of another. Typeinfo of another's classes, and virtual tables
    # of those that are all inline, are in each DLL that uses them, and exported; typeinfo is equal by name.
    target_compile_definitions(${target} PRIVATE TANDEM_DLL)
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-keep-inline-dllexport>)
    return()
  endif()
  set_target_properties(${target} PROPERTIES
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    INSTALL_RPATH "$ORIGIN"
    LINK_DEPENDS "${PROJECT_BINARY_DIR}/exports.map")
  target_link_options(${target} PRIVATE "LINKER:--version-script=${PROJECT_BINARY_DIR}/exports.map")
  if(NOT TANDEM_SANITIZE)
    target_link_options(${target} PRIVATE "LINKER:--no-undefined")
  endif()
endfunction()

# Compiles each public header of a module alone. It globs on purpose: a header that is not listed is
# checked too.
function(_tandem_header_check name)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}/include"
       "${CMAKE_CURRENT_SOURCE_DIR}/include/tandem/*.h"
       "${CMAKE_CURRENT_SOURCE_DIR}/include/tandem/*/*.h")
  set(sources)
  foreach(header IN LISTS headers)
    string(MAKE_C_IDENTIFIER "${header}" unit)
    set(source "${CMAKE_CURRENT_BINARY_DIR}/header_check/${unit}.cpp")
    # Twice: the second line tests the include guard.
    file(CONFIGURE OUTPUT "${source}" @ONLY CONTENT "#include \"${header}\"\n#include \"${header}\"\n")
    list(APPEND sources "${source}")
  endforeach()
  if(sources)
    add_library(tandem_${name}_headers OBJECT ${sources})
    _tandem_common(tandem_${name}_headers)
    set_target_properties(tandem_${name}_headers PROPERTIES UNITY_BUILD OFF)
    target_link_libraries(tandem_${name}_headers PRIVATE tandem::${name})
  endif()
endfunction()

# tandem_library(<name> SOURCES ... [LINK ...] [INCLUDE ...])
#
# A static library that several executables of this tree share; not installed. LINK and INCLUDE are
# passed on to its users.
function(tandem_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK;INCLUDE")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tandem_library(${name}): unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_library(${name} STATIC ${arg_SOURCES})
  _tandem_common(${name})
  target_link_libraries(${name} PUBLIC ${arg_LINK})
  target_include_directories(${name} PUBLIC ${arg_INCLUDE})
endfunction()

# tandem_executable(<name> SOURCES ... [LINK ...])
#
# A demo or a benchmark, in <build>/bin.
function(tandem_executable name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tandem_executable(${name}): unknown arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_executable(${name} ${arg_SOURCES})
  if(WIN32)
    target_sources(${name} PRIVATE "${PROJECT_SOURCE_DIR}/cmake/windows/utf8.rc")
  endif()
  _tandem_common(${name})
  target_link_libraries(${name} PRIVATE ${arg_LINK})
endfunction()

# tandem_test(<name> SOURCES ... [LINK ...])
#
# The tests of one module: executable <name>, or <name>_test where <name> is a module, in
# <build>/bin. It links what it names and nothing else, so the build shows what a module needs.
function(tandem_test name)
  if(NOT name MATCHES "_test$")
    set(target "${name}_test")
  else()
    set(target "${name}")
  endif()
  tandem_executable(${target} ${ARGN})
  if("undefined" IN_LIST TANDEM_SANITIZE)
    # What is looked at is in the libraries; checked tests take the compiler a third longer.
    target_compile_options(${target} PRIVATE -fno-sanitize=undefined)
  endif()
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests")
  target_link_libraries(${target} PRIVATE tandem_test_main)
  # One entry for the whole executable: listing its cases would run it while it is built, and a
  # sanitizer may need a prepared environment to start. Where instrumented or on another processor's
  # emulator, simulations that are long are left out: their steps are those of the others.
  set(cases)
  set(timeout 600)
  if(CMAKE_CROSSCOMPILING_EMULATOR MATCHES qemu)
    set(timeout 6000)
  endif()
  if(TANDEM_SANITIZE OR CMAKE_CROSSCOMPILING_EMULATOR MATCHES qemu)
    set(cases "~[long]")
  endif()
  if(CMAKE_CROSSCOMPILING_EMULATOR MATCHES wine)
    string(APPEND cases "~[not_on_wine]")
  endif()
  add_test(NAME ${target} COMMAND ${target} ${cases})
  set_tests_properties(${target} PROPERTIES TIMEOUT ${timeout})
endfunction()
