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

source "$here/timing.sh"

# consumer COMPONENT PREFIX PACKAGE...: configure (with these packages out of reach), build and run. Callers may
# have `options` for CMake and `runner`, which runs programs of another system.
options=()
runner=()
consumer() {
  local component=$1 prefix=$2 package program
  shift 2
  local hidden=()
  for package in "$@"; do
    hidden+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
  done
  cmake -S "$here" -B "$scratch/$component" -DCOMPONENT="$component" \
    -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release "${hidden[@]}" "${options[@]}" >"$scratch/log" 2>&1 &&
    cmake --build "$scratch/$component" >>"$scratch/log" 2>&1 ||
    fail_with_log "the consumer of $component does not build"
  program=$scratch/$component/consumer
  [[ ! -f $program.exe ]] || program+=.exe
  # By a file and without input, as wine goes on holding a pipe.
  "${runner[@]}" "$program" >"$scratch/said" 2>&1 </dev/null ||
    { cat "$scratch/said" >&2; fail "the consumer of $component fails"; }
  tr -d '\r' <"$scratch/said"
}

if [[ ! -f $build/CMakeCache.txt ]]; then
  (cd "$root" && cmake --preset "$2" -B "$build" >/dev/null)
fi
