# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What a way takes a user who has nothing but the package: begin, and took WAY, which prints the seconds since, and those
# that processors have worked, which other work on the machine does not lengthen. Wants a folder `scratch`.
# shellcheck shell=bash

# _now FILE: nanoseconds since 1970, and those that ended child processes of this shell have worked.
_now() {
  awk -v wall="$(date +%s%N)" \
    'NR == 2 {gsub(/[ms]/, " "); print wall, 1e9 * (60 * ($1 + $3) + $2 + $4)}' CONVFMT=%.0f OFMT=%.0f "$1"
}
# `times` not in a pipe, where it would be another process with other children.
begin() {
  times >"$scratch/times"
  _began=$(_now "$scratch/times")
}
took() {
  times >"$scratch/times"
  awk -v way="$1" -v began="$_began" '{
    split(began, b)
    printf "from nothing: %s: %.1f s, %.1f s of work\n", way, ($1 - b[1]) / 1e9, ($2 - b[2]) / 1e9
  }' <<<"$(_now "$scratch/times")"
}
