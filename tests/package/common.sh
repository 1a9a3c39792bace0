# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What the checks of packages have in common:
#   source common.sh NAME PRESET [BUILD]   BUILD is build/PRESET by default, configured where missing
# Sets here, root, build and scratch, which is gone in the end.
# shellcheck shell=bash
check=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
build=$(realpath -m "${3:-$root/build/$2}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

fail() {
  echo "$check: $*" >&2
  exit 1
}

# After a command that has written to $scratch/log.
fail_with_log() {
  cat "$scratch/log" >&2
  fail "$@"
}

# consumer COMPONENT PREFIX PACKAGE...: configure (with these packages out of reach), build and run.
consumer() {
  local component=$1 prefix=$2 package
  shift 2
  local hidden=()
  for package in "$@"; do
    hidden+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
  done
  cmake -S "$here" -B "$scratch/$component" -DCOMPONENT="$component" \
    -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release "${hidden[@]}" >"$scratch/log" 2>&1 &&
    cmake --build "$scratch/$component" >>"$scratch/log" 2>&1 ||
    fail_with_log "the consumer of $component does not build"
  "$scratch/$component/consumer" || fail "the consumer of $component fails"
}

if [[ ! -f $build/CMakeCache.txt ]]; then
  (cd "$root" && cmake --preset "$2" -B "$build" >/dev/null)
fi
