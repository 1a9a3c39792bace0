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
source "$(dirname "${BASH_SOURCE[0]}")/hosts.sh"

host=tandem-self-$$
add_host "$host"
# Four ports; of these the kernel takes those that are even as the first one to dial from.
ip netns exec "$host" sh -c 'echo 45000 45003 >/proc/sys/net/ipv4/ip_local_port_range' \
  2>"$folder/why" || skip "the ports to dial from cannot be chosen: $(cat "$folder/why")"

common=(--seconds 2 --wait 20 --print nothing)
on_host "$host" "$bin/cubes" --connect localhost:45002 "${common[@]}"
# Time to dial about ten times.
sleep 8
on_host "$host" "$bin/cubes" --listen 45002 "${common[@]}"
wait_for_all
echo "self_dial: who dialled himself met the other"
