#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# A process dials a port of its own host where nobody listens yet, and the kernel has hardly any other
# port to dial from: TCP joins such a socket to itself. It must go on dialling, and whoever comes to
# listen there must find the port free.
#   tests/net/self_dial.sh BIN
# Exits with 77 where this machine cannot do it, and says what is missing.
set -euo pipefail

bin=$1
skip() {
  echo "SKIPPED: $1"
  exit 77
}

[[ $(id -u) -eq 0 ]] || skip "network namespaces need root"
command -v ip >/dev/null || skip "there is no ip command (Debian: iproute2)"
host=tandem-self-$$
why=$(mktemp)
pids=()
cleanup() {
  [[ ${#pids[@]} -eq 0 ]] || kill "${pids[@]}" 2>/dev/null || true
  ip netns delete "$host" 2>/dev/null || true
  rm -f "$why"
}
trap cleanup EXIT

ip netns add "$host" 2>"$why" || skip "no network namespaces here: $(cat "$why")"
ip netns exec "$host" true 2>"$why" || skip "no command runs in one here: $(cat "$why")"
ip -n "$host" link set lo up
# Four ports; of these the kernel takes those that are even as the first one to dial from.
ip netns exec "$host" sh -c 'echo 45000 45003 >/proc/sys/net/ipv4/ip_local_port_range' 2>"$why" ||
  skip "the ports to dial from cannot be chosen: $(cat "$why")"

common=(--seconds 2 --wait 20 --quiet)
ip netns exec "$host" "$bin/cubes" --connect localhost:45002 "${common[@]}" &
pids+=($!)
# Time to dial about ten times.
sleep 8
ip netns exec "$host" "$bin/cubes" --listen 45002 "${common[@]}" &
pids+=($!)
for pid in "${pids[@]}"; do wait "$pid"; done
pids=()
echo "self_dial: who dialled himself met the other"
