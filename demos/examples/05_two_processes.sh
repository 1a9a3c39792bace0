#!/bin/sh
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Runs both processes of the example on a free port; returns 0 if both found the other's cube.
set -eu
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
: >"$folder/one"
"$program" listen 0 >"$folder/one" &
one=$!
port=
while [ -z "$port" ] && kill -0 "$one" 2>/dev/null; do
  port=$(sed -n 's/^port //p' "$folder/one")
  sleep 0.1
done
two=0
"$program" connect "localhost:$port" || two=$?
wait "$one"
cat "$folder/one"
exit "$two"
