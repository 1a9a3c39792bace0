// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tandem/c/tandem.h"
#include "tandem/pbd/validate.h"

namespace tandem::c {

/// Bytes of UTF-8 text that fit without splitting a character.
inline std::size_t whole_letters(std::string_view text, std::size_t room) {
  if (text.size() <= room) return text.size();
  while (room > 0 && (static_cast<unsigned char>(text[room]) & 0xc0) == 0x80) --room;
  return room;
}

inline tandem_result report(tandem_error* error, tandem_result result, std::string_view text) {
  if (error != nullptr) {
    error->result = result;
    const std::size_t length = whole_letters(text, sizeof error->text - 1);
    std::copy_n(text.data(), length, error->text);
    error->text[length] = '\0';
  }
  return result;
}

/// Runs `work`; an exception becomes a result with a text.
template <class Work>
tandem_result guarded(tandem_error* error, Work&& work) noexcept {
  try {
    work();
    return report(error, TANDEM_OK, "");
  } catch (const std::bad_alloc&) {
    return report(error, TANDEM_OUT_OF_MEMORY, "out of memory");
  } catch (const std::invalid_argument& fault) {
    return report(error, TANDEM_INVALID_ARGUMENT, fault.what());
  } catch (const std::exception& fault) {
    return report(error, TANDEM_FAILED, fault.what());
  } catch (...) {
    return report(error, TANDEM_FAILED, "an unknown fault");
  }
}

/// Result of `make`; null if it throws, with the reason in `error`.
template <class Make>
auto made_by(tandem_error* error, Make&& make) noexcept -> decltype(make()) {
  decltype(make()) made = nullptr;
  guarded(error, [&] { made = make(); });
  return made;
}

/// Throws std::invalid_argument if a required argument is null.
template <class T>
T& required(T* pointer, const char* name) {
  if (pointer == nullptr) pbd::detail::refuse(name, "given", "null");
  return *pointer;
}

/// Throws std::invalid_argument: the value is not listed in `type`.
[[noreturn]] inline void refuse_unlisted(const char* field, std::int32_t value, const char* type) {
  pbd::detail::refuse(field, std::string("one of ") + type, value);
}

}  // namespace tandem::c
