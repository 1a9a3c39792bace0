# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The page of a room in <build>/room: its files, the package tandem-physics, three.js, and the cipher, each
# compressed by gzip, as they are served.
set(sodium "${TANDEM_WEB_SOURCES}/libsodium/src/libsodium")
if(NOT EXISTS "${sodium}/sodium/utils.c")
  message(FATAL_ERROR "there are no sources in ${TANDEM_WEB_SOURCES}: bindings/web/fetch-sources.sh brings them")
endif()
file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/sodium/sodium/version.h" CONTENT
  "#define SODIUM_VERSION_STRING \"\"\n#define SODIUM_LIBRARY_VERSION_MAJOR 0\n#define SODIUM_LIBRARY_VERSION_MINOR 0\n")
set(sources
  crypto_aead/chacha20poly1305/sodium/aead_chacha20poly1305.c
  crypto_aead/xchacha20poly1305/sodium/aead_xchacha20poly1305.c
  crypto_core/hchacha20/core_hchacha20.c
  crypto_generichash/blake2b/ref/blake2b-compress-ref.c
  crypto_generichash/blake2b/ref/blake2b-ref.c
  crypto_generichash/blake2b/ref/generichash_blake2b.c
  crypto_generichash/crypto_generichash.c
  crypto_onetimeauth/poly1305/donna/poly1305_donna.c
  crypto_onetimeauth/poly1305/onetimeauth_poly1305.c
  crypto_stream/chacha20/ref/chacha20_ref.c
  crypto_stream/chacha20/stream_chacha20.c
  crypto_verify/sodium/verify.c
  sodium/utils.c)
list(TRANSFORM sources PREPEND "${sodium}/")
add_executable(tandem_room_cipher cipher/cipher.cpp cipher/glue.cpp cipher/no_sodium.c ${sources})
target_compile_features(tandem_room_cipher PRIVATE cxx_std_20)
set_target_properties(tandem_room_cipher PROPERTIES OUTPUT_NAME cipher SUFFIX .wasm UNITY_BUILD OFF
  RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS "-w")
target_include_directories(tandem_room_cipher PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
target_include_directories(tandem_room_cipher SYSTEM PRIVATE
  "${CMAKE_CURRENT_BINARY_DIR}/sodium" "${CMAKE_CURRENT_BINARY_DIR}/sodium/sodium" "${sodium}/include"
  "${sodium}/include/sodium")
target_compile_definitions(tandem_room_cipher PRIVATE CONFIGURED=1 NATIVE_LITTLE_ENDIAN=1 SODIUM_STATIC=1)
set(functions _malloc _free _room_cipher_create _room_cipher_destroy _room_cipher_hello _room_cipher_seal
  _room_cipher_open _room_cipher_alive)
list(JOIN functions "," functions)
target_link_options(tandem_room_cipher PRIVATE --no-entry -O3 -sSTANDALONE_WASM -sWASM_BIGINT
  -sERROR_ON_UNDEFINED_SYMBOLS=0 "-sEXPORTED_FUNCTIONS=${functions}")

# three.js as the live view has it pinned, and a file of its page.
set(view "${PROJECT_SOURCE_DIR}/demos/view/page")
set(npm "${CMAKE_CURRENT_BINARY_DIR}/npm")
set(three "${npm}/node_modules/three/build")
find_program(TANDEM_NPM npm REQUIRED)
add_custom_command(OUTPUT "${three}/three.core.min.js"
  COMMAND "${CMAKE_COMMAND}" -E copy_if_different "${view}/package.json" "${view}/package-lock.json" "${npm}"
  COMMAND "${TANDEM_NPM}" ci --prefix "${npm}" --ignore-scripts --no-audit --no-fund --loglevel=error
  DEPENDS "${view}/package-lock.json" VERBATIM)
file(MAKE_DIRECTORY "${npm}")

file(GLOB page CONFIGURE_DEPENDS page/*.html page/*.js page/*.css page/*.svg page/*.json)
list(APPEND page "${view}/software.js")
set(package "${PROJECT_BINARY_DIR}/package")
add_custom_command(OUTPUT "${PROJECT_BINARY_DIR}/room/index.html.gz"
  COMMAND "${TANDEM_NODE}" "${CMAKE_CURRENT_SOURCE_DIR}/compress.mjs" "${PROJECT_BINARY_DIR}/room" ${page}
    "${package}/tandem.js" "${package}/layout.js" "${package}/tandem.wasm"
    "${three}/three.module.min.js" "${three}/three.core.min.js" "$<TARGET_FILE:tandem_room_cipher>"
  DEPENDS compress.mjs ${page} tandem_room_cipher tandem_web_package "${package}/compat.js"
    "${three}/three.core.min.js"
  VERBATIM)
# The same as one file of a release: unpacked, the folder that tandem-room serves. The same files give the same archive.
set(archive "tandem-room-page-${PROJECT_VERSION}")
add_custom_command(OUTPUT "${PROJECT_BINARY_DIR}/${archive}.tar.gz"
  COMMAND bash "${CMAKE_CURRENT_SOURCE_DIR}/archive.sh" "${PROJECT_BINARY_DIR}/room" "${archive}"
    "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/demos/NOTICES.txt" "${PROJECT_BINARY_DIR}/${archive}.tar.gz"
  DEPENDS archive.sh "${PROJECT_BINARY_DIR}/room/index.html.gz" "${PROJECT_SOURCE_DIR}/demos/NOTICES.txt"
  VERBATIM)
add_custom_target(tandem_room_page ALL DEPENDS "${PROJECT_BINARY_DIR}/${archive}.tar.gz")
