#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# What each demo records is glTF to the Khronos validator, and what is not is none.
#   tests/demos/gltf/run.sh BIN [MODULES]   MODULES: where npm keeps the validator between runs
# Exits with 77 where there is no npm, or no way to the validator, and says so.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$1
skip() {
  echo "SKIPPED: $1"
  exit 77
}
command -v npm >/dev/null && command -v node >/dev/null ||
  skip "the glTF validator needs npm (Debian: nodejs, npm)"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
modules=${2:-$folder/modules}
mkdir -p "$modules"
cp "$here/package.json" "$here/package-lock.json" "$here/validate.mjs" "$modules"
if [[ ! -d $modules/node_modules/gltf-validator ]]; then
  (cd "$modules" && npm ci --ignore-scripts --no-audit --no-fund --fetch-retries 1) \
    >"$folder/npm.log" 2>&1 || {
    tail -5 "$folder/npm.log"
    skip "npm does not get the glTF validator"
  }
fi

demos=(cliff cubes piano pile room tennis)
for demo in "${demos[@]}"; do
  "$bin/$demo" --seconds 2 --print nothing --record "$folder/$demo.glb" >"$folder/$demo.log" || {
    cat "$folder/$demo.log"
    echo "$demo does not record"
    exit 1
  }
done
# Peers that step at other rates, and more of them.
"$bin/cubes" --seconds 2 --print nothing --peers 3 --rates 60,72 --record "$folder/uneven.glb" >/dev/null
node "$modules/validate.mjs" "$folder"/*.glb

# The check of the check: an accessor that reaches beyond its buffer is an error.
node - "$folder/cubes.glb" "$folder/broken.glb" <<'END'
const fs = require("fs");
const [from, to] = process.argv.slice(2);
const bytes = fs.readFileSync(from);
const length = bytes.readUInt32LE(12);
const text = bytes.toString("utf8", 20, 20 + length);
const broken = text.replace(/"count":(\d)/, (_, digit) => `"count":${digit === "9" ? 8 : 9}`);
if (broken === text) process.exit(1);
bytes.write(broken, 20, "utf8");
fs.writeFileSync(to, bytes);
END
if node "$modules/validate.mjs" "$folder/broken.glb" >"$folder/broken.log"; then
  cat "$folder/broken.log"
  echo "the validator finds nothing in a broken file"
  exit 1
fi
