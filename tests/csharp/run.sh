#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The C# sources and their tests by mono: run.sh FOLDER MCS MONO, with what was built in FOLDER.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
runtime=$here/../../bindings/csharp/Runtime
samples=$here/../../bindings/csharp/Samples~
folder=$1 mcs=$2 mono=$3

# C# 7 without its later versions, as little as Unity and mono have in common.
compile() {
  "$mcs" -langversion:7 -unsafe -warn:4 -warnaserror "$@"
}

compile -out:"$folder/tests.exe" "$runtime"/*.cs "$samples/Table/TableRoom.cs" "$here"/*.cs
# What Unity compiles, against the few of its names that it uses: no more than a check of types.
compile -target:library -define:UNITY_5_3_OR_NEWER -out:"$folder/unity.dll" \
  "$here"/unity/*.cs "$runtime"/*.cs "$samples"/*/*.cs

"$folder/csharp_reference" >"$folder/reference.txt"
"$mono" --debug "$folder/tests.exe" "$folder/reference.txt"
