#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The C# sources and their tests by mono: run.sh FOLDER MCS MONO, with what was built in FOLDER.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
runtime=$here/../../bindings/csharp/Runtime
samples=$here/../../bindings/csharp/Samples~
page=$here/../../docs/csharp.md
folder=$1 mcs=$2 mono=$3

# C# 7 without its later versions, as little as Unity and mono have in common.
compile() {
  "$mcs" -langversion:7 -unsafe -warn:4 -warnaserror "$@"
}

compile -out:"$folder/tests.exe" "$runtime"/*.cs "$samples/Table/TableRoom.cs" "$here"/*.cs
# The sources that Unity compiles, against the few of its names that they use: only a check of
# types.
compile -target:library -define:UNITY_5_3_OR_NEWER -out:"$folder/unity.dll" \
  "$here"/unity/*.cs "$runtime"/*.cs "$samples"/*/*.cs

"$folder/csharp_reference" >"$folder/reference.txt"
"$mono" --debug "$folder/tests.exe" "$folder/reference.txt"

# The programs of the page, as they stand there.
block() {
  awk -v head="\`\`\`$1" '$0 == head { inside = 1; next } /^```/ { inside = 0 } inside' "$page"
}
for program in First Shared; do
  block "csharp $program.cs" >"$folder/$program.cs"
  compile -out:"$folder/$program.exe" "$folder/$program.cs" "$runtime"/*.cs
done
"$mono" "$folder/First.exe" | diff - <(block "text First.cs")
port=$((20000 + $$ % 20000))
timeout 60 "$mono" "$folder/Shared.exe" 1 "$port" >"$folder/first.txt" &
first=$!
trap 'kill "$first" 2>/dev/null || true' EXIT
timeout 60 "$mono" "$folder/Shared.exe" 2 "$port" >"$folder/second.txt"
wait "$first"
grep -qE '^peer 1: the cube is at (1\.0[0-4]|0\.9[6-9]) m$' "$folder/first.txt"
grep -qE '^peer 2: the cube is at (1\.0[0-4]|0\.9[6-9]) m$' "$folder/second.txt"
echo "page: ok"
