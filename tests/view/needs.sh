# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# For scripts that drive a page with a headless Chromium: `name` is theirs, as skip() says it.

# Ends with 77: it lacks what it needs.
skip() {
  echo "$name: skipped: $1" >&2
  exit 77
}

# npm_modules FOLDER...: the modules of each are there, or it ends.
npm_modules() {
  local folder
  for folder in "$@"; do
    [[ -d $folder/node_modules ]] || npm --prefix "$folder" ci --no-audit --no-fund > /dev/null ||
      skip "npm ci failed in $folder"
  done
}

command -v node > /dev/null || skip 'no Node.js (Debian: nodejs, at least 18)'
[[ $(node -p 'process.versions.node.split(".")[0]') -ge 18 ]] || skip 'Node.js is older than 18'
command -v npm > /dev/null || skip 'no npm (Debian: npm)'
if [[ -z ${CHROMIUM:-} ]]; then
  command -v chromium chromium-browser google-chrome > /dev/null || skip 'no Chromium (Debian: chromium)'
fi
