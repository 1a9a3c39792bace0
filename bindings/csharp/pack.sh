#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The package for Unity, with what was built for each system: pack.sh FOLDER BUILD...
#   bindings/csharp/pack.sh build/unity build/csharp_linux build/csharp_x86_64-windows
# makes FOLDER/com.tandem.physics and FOLDER/com.tandem.physics-VERSION.tgz. The same files give the same archive.
# Says which libraries of the system's a build wants besides C's own.
set -euo pipefail

[[ $# -ge 2 ]] || { echo "usage: pack.sh FOLDER BUILD..." >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
name=com.tandem.physics
version=$(sed -n 's/^ *"version": "\(.*\)",$/\1/p' "$here/package.json")
folder=$1/$name
shift

fail() {
  echo "pack.sh: $1" >&2
  exit 1
}

grep -q "^project(tandem VERSION $version " "$here/../../CMakeLists.txt" || fail "package.json has not Tandem's version"

# Which folder of Plugins a library is for, by its header.
place() {
  case $(od -An -tx1 -N20 "$1" | tr -d ' \n') in
    7f454c4602*3e00) echo Linux/x86_64 ;;
    7f454c4602*b700) echo Linux/arm64 ;;
    4d5a*) echo Windows/x86_64 ;;
    *) fail "$1 is for none of the systems that there are folders for" ;;
  esac
}

needs() {
  local others
  others=$(LC_ALL=C objdump -p "$1" 2>/dev/null | sed -n 's/^ *\(NEEDED\|DLL Name:\) *//p' |
    grep -viE '^(lib(c|m|gcc_s|pthread|dl)\.so|ld-linux|KERNEL32|msvcrt|ADVAPI32|WS2_32|MSWSOCK|USER32)' || true)
  [[ -z $others ]] || echo "  and wants of the system: ${others//$'\n'/, }"
}

# Unity names files by an id of 32 digits; in a package that it may not write to each has to have one.
meta() {
  local file=$1 importer=$2 id
  id=$(printf '%s' "$name/${file#"$folder/"}" | md5sum | cut -c1-32)
  printf 'fileFormatVersion: 2\nguid: %s\n%s' "$id" "${importer:+$importer$'\n'}" >"$file.meta"
}

# plugin OS CPU TARGET: for the editor and the player of one system.
plugin() {
  cat <<END
PluginImporter:
  serializedVersion: 2
  isPreloaded: 0
  isOverridable: 0
  platformData:
  - first:
      Any:
    second:
      enabled: 0
      settings: {}
  - first:
      Editor: Editor
    second:
      enabled: 1
      settings:
        CPU: $2
        DefaultValueInitialized: true
        OS: $1
  - first:
      Standalone: $3
    second:
      enabled: 1
      settings:
        CPU: $2
END
}

rm -rf "$folder"
mkdir -p "$folder"
cp -r "$here"/{package.json,README.md,Runtime,Plugins,Samples~} "$here/../../LICENSE" "$folder"
mv "$folder/LICENSE" "$folder/LICENSE.md"
for build in "$@"; do
  found=
  for library in "$build"/csharp/{libtandem_csharp.so,tandem_csharp.dll}; do
    [[ -f $library ]] || continue
    found=$folder/Plugins/$(place "$library")/$(basename "$library")
    [[ ! -f $found ]] || fail "two builds are for $(place "$library")"
    cp "$library" "$found"
    rm -f "$(dirname "$found")/README.md"
    echo "pack.sh: ${found#"$folder/"}"
    needs "$found"
  done
  [[ -n $found ]] || fail "there is no library in $build/csharp: build its target tandem_csharp"
done
find "$folder/Plugins" -name README.md -delete
find "$folder/Plugins" -type d -empty -delete

find "$folder" -mindepth 1 -not -path '*~*' -not -name '*.meta' | LC_ALL=C sort | while IFS= read -r file; do
  case $file in
    */Linux/x86_64/*) meta "$file" "$(plugin Linux x86_64 Linux64)" ;;
    */Linux/arm64/*) meta "$file" "$(plugin Linux ARM64 Linux64)" ;;
    */Windows/x86_64/*) meta "$file" "$(plugin Windows x86_64 Win64)" ;;
    *) if [[ -d $file ]]; then meta "$file" 'folderAsset: yes'; else meta "$file" ''; fi ;;
  esac
done

# As npm lays it out.
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --transform "s,^$name,package," \
  -C "$(dirname "$folder")" -cf - "$name" | gzip -n >"$folder-$version.tgz"
echo "pack.sh: $folder-$version.tgz"
