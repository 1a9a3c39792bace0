#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# The npm package as it would be published: packed, installed into a new project, used there.
#   tests/package/npm.sh [FOLDER]   default build/web/package, target tandem_web_package of preset web
# Exits with 77 where there is no npm, and says so.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
package=${1:-$root/build/web/package}
scratch=$(mktemp -d)
source "$root/tests/package/timing.sh"
trap 'rm -rf "$scratch"' EXIT

fail() {
  echo "npm: $*" >&2
  exit 1
}
command -v npm >/dev/null || {
  echo "SKIPPED: there is no npm"
  exit 77
}
[[ -f $package/compat.js ]] || fail "there is no package in $package (preset web, target tandem_web_package)"

npm pack --silent --pack-destination "$scratch" "$package" >/dev/null
archive=$(echo "$scratch"/*.tgz)
version=$(sed -n 's/^project(tandem VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
[[ $(basename "$archive") == tandem-physics-$version.tgz ]] || fail "it is called $archive"
tar -tzf "$archive" | sort >"$scratch/list"
for file in LICENSE NOTICES.txt README.md package.json tandem.js layout.js tandem.d.ts tandem.wasm compat.js; do
  grep -qxF "package/$file" "$scratch/list" || fail "there is no $file in it"
done
[[ $(wc -l <"$scratch/list") -eq 9 ]] || fail "there is more in it:"$'\n'"$(<"$scratch/list")"
tar -C "$scratch" -xzf "$archive"
! grep -rlF "$root" "$scratch/package" || fail "the files above know where they were built"

begin
mkdir "$scratch/project"
cp "$root/tests/package/fall.mjs" "$scratch/project/fall.mjs"
cd "$scratch/project"
npm init --yes >/dev/null
npm install --offline --no-audit --no-fund --silent "$archive" || fail "npm does not take $archive"
node fall.mjs || fail "the package does not run"
sed "s,from 'tandem-physics',from 'tandem-physics/compat'," fall.mjs >compat.mjs
node compat.mjs >/dev/null || fail "the package for pages that load scripts alone does not run"
took npm
echo "npm: $(stat -c %s "$archive") bytes"
