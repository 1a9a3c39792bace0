# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Hosts of one's own on one machine, for tests that source this: network namespaces, which are gone in
# the end with $folder and all that runs. Ends the test with 77 where this machine cannot do it.
# shellcheck shell=bash
folder=$(mktemp -d)
hosts=()
pids=()
cleanup() {
  local host
  [[ ${#pids[@]} -eq 0 ]] || kill "${pids[@]}" 2>/dev/null || true
  for host in "${hosts[@]}"; do ip netns delete "$host" 2>/dev/null || true; done
  rm -rf "$folder"
}
trap cleanup EXIT

skip() {
  echo "SKIPPED: $1"
  exit 77
}

[[ $(id -u) -eq 0 ]] || skip "network namespaces need root"
command -v ip >/dev/null || skip "there is no ip command (Debian: iproute2)"

# add_host NAME: with loopback alone.
add_host() {
  hosts+=("$1")
  ip netns add "$1" 2>"$folder/why" || skip "no network namespaces here: $(cat "$folder/why")"
  ip netns exec "$1" true 2>"$folder/why" || skip "no command runs in one here: $(cat "$folder/why")"
  ip -n "$1" link set lo up
}

# on_host NAME COMMAND...: in the background.
on_host() {
  ip netns exec "$@" &
  pids+=($!)
}

# Ends the test where one of them fails.
wait_for_all() {
  local pid
  for pid in "${pids[@]}"; do wait "$pid"; done
  pids=()
}
