// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace tandem::pbd::detail {

/// An array of zeros that takes memory page by page when elements are written, so that unused
/// elements are free. For trivially copyable types with zero as a valid value: new elements are
/// zeros and not `T{}`.
template <class T>
class SparseArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  SparseArray() = default;
  SparseArray(SparseArray&& other) noexcept { swap(other); }
  SparseArray(const SparseArray& other) { *this = other; }
  SparseArray& operator=(SparseArray&& other) noexcept {
    SparseArray(std::move(other)).swap(*this);
    return *this;
  }
  SparseArray& operator=(const SparseArray& other) {
    if (this == &other) return *this;
    resize(other.size_);
    copy(other.data_, other.size_);
    return *this;
  }

  /// New elements are zero.
  void resize(std::size_t size) {
    if (size > capacity_) reserve(std::max(size, capacity_ + capacity_ / 2));
    if (size > size_ && used_ > size_) clear(size_, std::min(size, used_));
    used_ = std::max(used_, size);
    size_ = size;
  }

  void reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    SparseArray grown;
    // calloc() maps large blocks as untouched zero pages.
    if (capacity > (SIZE_MAX - alignof(T)) / sizeof(T)) throw std::bad_alloc();
    std::size_t room = capacity * sizeof(T) + alignof(T);
    grown.memory_.reset(std::calloc(room, 1));
    void* at = grown.memory_.get();
    if (at == nullptr) throw std::bad_alloc();
    grown.data_ = static_cast<T*>(std::align(alignof(T), capacity * sizeof(T), at, room));
    grown.size_ = grown.used_ = size_;
    grown.capacity_ = capacity;
    grown.copy(data_, size_);
    swap(grown);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  T* begin() { return data_; }
  const T* begin() const { return data_; }
  T* end() { return data_ + size_; }
  const T* end() const { return data_ + size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  void swap(SparseArray& other) {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(used_, other.used_);
    std::swap(capacity_, other.capacity_);
  }
  // Both skip pages that are equal already.
  void copy(const T* source, std::size_t count) {
    const auto* from = reinterpret_cast<const std::byte*>(source);
    for_blocks(0, count, [&](std::byte* to, std::size_t at, std::size_t bytes) {
      if (std::memcmp(to, from + at, bytes) != 0) std::memcpy(to, from + at, bytes);
    });
  }
  void clear(std::size_t begin, std::size_t end) {
    for_blocks(begin, end, [](std::byte* to, std::size_t, std::size_t bytes) {
      const bool zero = *to == std::byte{0} && std::memcmp(to, to + 1, bytes - 1) == 0;
      if (!zero) std::memset(to, 0, bytes);
    });
  }
  void for_blocks(std::size_t begin, std::size_t end, auto&& visit) {
    constexpr std::size_t kBlock = 4096;  // bytes
    for (std::size_t at = begin * sizeof(T); at < end * sizeof(T); at += kBlock) {
      visit(reinterpret_cast<std::byte*>(data_) + at, at, std::min(end * sizeof(T) - at, kBlock));
    }
  }

  std::unique_ptr<void, Free> memory_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t used_ = 0;  ///< largest size so far
  std::size_t capacity_ = 0;
};

}  // namespace tandem::pbd::detail
