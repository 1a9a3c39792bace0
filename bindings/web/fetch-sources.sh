#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Brings Debian's sources of FCL, libccd and libsodium, which its packages have for native processors only.
#   bindings/web/fetch-sources.sh FOLDER
# Needs apt-get and dpkg-dev, neither root nor deb-src in the system's lists; what is there stays.
set -euo pipefail

[[ $# -eq 1 ]] || { echo "usage: fetch-sources.sh FOLDER" >&2; exit 2; }
mkdir -p "$1"
cd "$1"
packages=(fcl libccd libsodium)
missing=()
for package in "${packages[@]}"; do
  [[ -d $package ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

lists=$(mktemp -d)
trap 'rm -rf "$lists"' EXIT
mkdir -p "$lists/sources" "$lists/lists/partial" "$lists/cache"
cat >"$lists/sources/debian.sources" <<'SOURCES'
Types: deb-src
URIs: http://deb.debian.org/debian
Suites: bookworm
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
SOURCES
apt=(apt-get -qq -o Dir::Etc::SourceList=/dev/null -o "Dir::Etc::SourceParts=$lists/sources"
  -o "Dir::State::Lists=$lists/lists" -o "Dir::Cache=$lists/cache" -o APT::Sandbox::User=)
"${apt[@]}" update
"${apt[@]}" source --download-only "${missing[@]}"
for package in "${missing[@]}"; do
  rm -rf "$package"
  dpkg-source --extract "$package"_*.dsc "$package" >/dev/null
done
