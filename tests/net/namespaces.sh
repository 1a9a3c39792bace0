#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Two demo processes on two hosts: network namespaces joined by a veth pair, over UDP, encrypted.
#   tests/net/namespaces.sh BIN plain    nothing on the way
#   tests/net/namespaces.sh BIN netem    30 +- 2 ms and 5 % loss each way, by the kernel
# Exits with 77 where this machine cannot do it, and says what is missing.
set -euo pipefail

bin=$1
way=$2
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"
[[ -x $bin/tandem-key ]] || skip "built without libsodium: no UDP"

a=tandem-a-$$ b=tandem-b-$$
add_host "$a"
add_host "$b"
ip link add name veth0 netns "$a" type veth peer name veth0 netns "$b" 2>"$folder/why" ||
  skip "no veth pairs here: $(cat "$folder/why")"
ip -n "$a" addr add 10.77.0.1/24 dev veth0
ip -n "$b" addr add 10.77.0.2/24 dev veth0
for host in "$a" "$b"; do
  ip -n "$host" link set veth0 up
  [[ $way == netem ]] || continue
  command -v tc >/dev/null || skip "there is no tc command (Debian: iproute2)"
  ip netns exec "$host" tc qdisc add dev veth0 root netem delay 30ms 2ms loss 5% \
    2>"$folder/why" || skip "this kernel has no netem: $(head -1 "$folder/why")"
done

(umask 077 && "$bin/tandem-key" >"$folder/key")
common=(--key "$folder/key" --seconds 8 --wait 20 --print nothing)
on_host "$a" "$bin/cubes" --listen 7777 "${common[@]}" --json "$folder/a.json"
on_host "$b" "$bin/cubes" --connect 10.77.0.1:7777 "${common[@]}" --json "$folder/b.json"
# 0: the worlds stayed whole.
wait_for_all

# The first number of a key after an object's begin.
number() {
  sed -n "/\"$2\":/,/}/ s/.*\"$3\": *\([0-9.e+-]*\).*/\1/p" "$1" | head -1
}
for peer in a b; do
  moving=$(number "$folder/$peer.json" divergence_moving_m p50)
  resting=$(number "$folder/$peer.json" divergence_resting_m p50)
  count=$(number "$folder/$peer.json" divergence_moving_m count)
  echo "$peer: moving p50 $moving m, resting p50 $resting m, $count samples moving"
  # Bounds of two processes on one host for plain; of profile 3, which is as late, with netem.
  awk -v m="$moving" -v r="$resting" -v n="$count" -v way="$way" 'BEGIN {
    exit !(m != "" && n > 300 && m <= (way == "netem" ? 10e-3 : 5e-3) && r <= 0.5e-3) }' || {
    echo "the peers do not agree" >&2
    exit 1
  }
done
