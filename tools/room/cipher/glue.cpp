// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The cipher for the page: arguments in the module's memory, random bytes from the browser.
#include <algorithm>
#include <exception>
#include <memory>
#include <string_view>

#include "cipher/cipher.h"

using tandem::room::Bytes;
using tandem::room::Cipher;
using tandem::room::View;

extern "C" {

__attribute__((import_module("room"), import_name("random"))) void room_random(std::uint8_t* bytes,
                                                                               std::uint32_t size);

/// Null if key or id are invalid.
Cipher* room_cipher_create(const std::uint8_t* key, std::uint32_t key_size, const char* room,
                           std::uint32_t room_size, std::uint64_t self) {
  try {
    return std::make_unique<Cipher>(View(key, key_size), std::string_view(room, room_size), self,
                                    [](std::span<std::uint8_t> bytes) {
                                      room_random(bytes.data(),
                                                  static_cast<std::uint32_t>(bytes.size()));
                                    })
        .release();
  } catch (const std::exception&) {
    return nullptr;
  }
}

void room_cipher_destroy(Cipher* cipher) { delete cipher; }

/// Each overwrites `bytes`, which must have room for 64 KiB. @return the length; -1: refused
std::int32_t room_cipher_hello(const Cipher* cipher, std::uint8_t* bytes, std::uint32_t size) {
  try {
    const Bytes out = cipher->hello(View(bytes, size));
    std::copy(out.begin(), out.end(), bytes);
    return static_cast<std::int32_t>(out.size());
  } catch (const std::exception&) {
    return -1;
  }
}

std::int32_t room_cipher_seal(Cipher* cipher, std::uint64_t to, std::uint8_t* bytes,
                              std::uint32_t size) {
  Bytes out;
  if (!cipher->seal(to, View(bytes, size), out)) return -1;
  std::copy(out.begin(), out.end(), bytes);
  return static_cast<std::int32_t>(out.size());
}

/// @return the kind (Cipher::Kind) in the upper 8 bits, the length in the lower 24
std::uint32_t room_cipher_open(Cipher* cipher, std::uint64_t from, std::uint8_t* bytes,
                               std::uint32_t size) {
  Bytes out;
  const Cipher::Kind kind = cipher->open(from, View(bytes, size), out);
  std::copy(out.begin(), out.end(), bytes);
  return static_cast<std::uint32_t>(kind) << 24 | static_cast<std::uint32_t>(out.size());
}

std::int32_t room_cipher_alive(const Cipher* cipher, std::uint64_t id) {
  return cipher->alive(id) ? 1 : 0;
}

}  // extern "C"
