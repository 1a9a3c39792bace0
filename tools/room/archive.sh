#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Packs the page of rooms with its licences into one file:
#   archive.sh FOLDER NAME LICENSE NOTICES ARCHIVE
set -euo pipefail
[[ $# -eq 5 ]] || { echo "usage: archive.sh FOLDER NAME LICENSE NOTICES ARCHIVE" >&2; exit 2; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir "$scratch/$2"
cp "$1"/*.gz "$3" "$4" "$scratch/$2"
chmod 644 "$scratch/$2"/*
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw -C "$scratch" -cf - "$2" | gzip -9 -n >"$5"
