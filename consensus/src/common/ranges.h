// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <functional>
#include <iterator>

/// Algorithms over whole ranges, with projections: the part of std::ranges that is used here, which
/// the C++ library of emscripten 3.1 lacks.
namespace tandem::consensus::ranges {

struct Element {
  template <class T>
  const T& operator()(const T& element) const {
    return element;
  }
};

template <class Range, class Test>
bool any_of(const Range& range, Test test) {
  return std::any_of(std::begin(range), std::end(range), test);
}

template <class Range, class Value, class Key = Element>
auto find(Range&& range, const Value& value, Key key = {}) {
  return std::find_if(std::begin(range), std::end(range),
                      [&](const auto& e) { return std::invoke(key, e) == value; });
}

template <class Range, class Value, class Key = Element>
auto lower_bound(Range&& range, const Value& value, Key key = {}) {
  return std::lower_bound(std::begin(range), std::end(range), value,
                          [&](const auto& e, const Value& v) { return std::invoke(key, e) < v; });
}

template <class Range, class Value, class Key = Element>
bool binary_search(const Range& range, const Value& value, Key key = {}) {
  const auto at = lower_bound(range, value, key);
  return at != std::end(range) && std::invoke(key, *at) == value;
}

/// no two keys are equal: libraries differ in the order of equal ones
template <class Range, class Key = Element>
void sort(Range& range, Key key = {}) {
  std::sort(std::begin(range), std::end(range), [&](const auto& l, const auto& r) {
    return std::invoke(key, l) < std::invoke(key, r);
  });
}

}  // namespace tandem::consensus::ranges
