#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Packages for Debian: made, unpacked into a folder, and used from there.
#   tests/package/deb.sh [BUILD [PRESET]]   default build/shared and shared; configured where missing. With
#                                           arm64_shared the programs run on qemu
# Exits with 77 where there is no dpkg-deb, and says so.
set -euo pipefail
command -v dpkg-deb >/dev/null || {
  echo "SKIPPED: there is no dpkg-deb"
  exit 77
}

preset=${2:-shared}
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" deb "$preset" "${1-}"
if [[ $preset == arm64_shared ]]; then
  options=(-DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/aarch64-linux.cmake" -DEigen3_DIR=/usr/share/eigen3/cmake)
  runner=(qemu-aarch64 -L /usr/aarch64-linux-gnu)
fi
# The packed files, and nothing else.
targets=(tandem_scene tandem_session tandem_obj tandem_scene_files tandem_c_session tandem_c_files)
known=$(cmake --build "$build" --target help)
for program in cliff cubes piano pile room tennis tandem-key tandem-peer tandem-replay tandem-room tandem-room-peer; do
  if grep -qE "^$program:" <<<"$known"; then targets+=("$program"); fi
done
cmake --build "$build" --target "${targets[@]}"

(cd "$build" && cpack -G DEB -B "$scratch/packages") >"$scratch/log" 2>&1 ||
  fail_with_log "cpack fails"
packages=("$scratch"/packages/*.deb)
[[ ${#packages[@]} -eq 3 ]] || fail "these are not three packages: ${packages[*]}"
begin
for package in "${packages[@]}"; do
  name=$(dpkg-deb -f "$package" Package)
  echo "deb: $(basename "$package"), $(stat -c %s "$package") bytes: $(dpkg-deb -f "$package" Depends)"
  dpkg-deb -x "$package" "$scratch/unpacked"
  dpkg-deb -c "$package" >"$scratch/$name.list"
done

# Each file is in the package that it belongs to.
has() {
  grep -qE "$2" "$scratch/$1.list" || fail "$1 has no $2"
}
hasnt() {
  ! sed 's/ -> .*//' "$scratch/$1.list" | grep -E "$2" || fail "$1 has $2"
}
libraries=$(cd "$scratch" && echo libtandem0.*.list)
libraries=${libraries%.list}
has "$libraries" 'libtandem_pbd\.so\.[0-9.]+$'
hasnt "$libraries" '\.(h|cmake|pc|so)$|/bin/'
has libtandem-dev 'include/tandem/pbd/world\.h$'
has libtandem-dev 'libtandem_net\.so -> '
has libtandem-dev 'tandemConfig\.cmake$'
has libtandem-dev 'tandem-c\.pc$'
has libtandem-dev 'tandem-c_session\.pc$'
hasnt libtandem-dev '/bin/|\.so\.[0-9.]+$'
has tandem-demos 'bin/tandem-demo$'
has tandem-demos 'bin/tandem-key$'
has tandem-demos 'doc/tandem-demos/NOTICES\.txt(\.gz)?$'
hasnt tandem-demos '\.(h|so[0-9.]*)$'
needed=libfcl
[[ $preset == shared ]] || needed=libstdc++6
dpkg-deb -f "$scratch"/packages/"$libraries"_*.deb Depends | grep -q "$needed" ||
  fail "what the libraries need is not told"
[[ $preset == shared ]] || for name in fcl ccd sodium tinyobjloader; do
  has "$libraries" "licenses/lib$name-dev\\.txt(\\.gz)?\$"
done
dpkg-deb -f "$scratch"/packages/libtandem-dev_*.deb Depends | grep -q "$libraries (= " ||
  fail "the headers do without their libraries"

# Nothing in them knows where they were built.
! grep -rlF -e "$build" -e "$root" "$scratch/unpacked" || fail "the files above know where they were built"

usr=$scratch/unpacked/usr
folder=$(dirname "$(find "$usr" -name libtandem_pbd.so)")
export LD_LIBRARY_PATH=$folder
if [[ $preset == shared ]]; then
  "$usr/bin/tandem-demo" cubes --seconds 1 --print nothing || fail "a demo does not run"
else
  unset LD_LIBRARY_PATH
  runner+=(-E "LD_LIBRARY_PATH=$folder")
  "${runner[@]}" "$usr/libexec/tandem/demos/cubes" --seconds 1 --print nothing </dev/null || fail "a demo does not run"
fi
consumer scene "$usr"
took deb
consumer net "$usr"
"${runner[@]}" "$usr/bin/tandem-key" >/dev/null </dev/null || fail "tandem-key does not run"
ran=()
for program in "$usr"/bin/tandem-* "$usr"/libexec/tandem/demos/*; do
  [[ $(head -c 4 "$program") == $'\x7fELF' ]] || continue  # tandem-demo is a script
  "${runner[@]}" "$program" --help >"$scratch/said" 2>&1 </dev/null || { cat "$scratch/said" >&2; fail "$program does not run"; }
  ran+=("$(basename "$program")")
done
echo "deb: these say what they take: ${ran[*]}"
# Rooms need nothing else where the page is there: what is served with no option.
if [[ $preset == shared && -x $usr/bin/tandem-room && -f $usr/share/tandem/room/index.html.gz ]]; then
  "$here/room.sh" "$usr/bin/tandem-room" || fail "tandem-room does not serve the installed page"
else
  echo "deb: no page of rooms in it (target tandem_room_page of preset web)"
fi
if command -v lintian >/dev/null; then
  # Errors alone. The packager is named when they are published.
  lintian --fail-on error --suppress-tags bogus-mail-host,no-changelog "${packages[@]}" \
    >"$scratch/log" 2>&1 || fail_with_log "lintian has errors"
  echo "deb: lintian has no error and $(grep -c '^W:' "$scratch/log" || true) warnings"
fi
echo "deb: the packages can be used"
