#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Installs dependencies, builds Release and runs a demo: piano at profile 4, compared with a single owner;
# or cliff, cubes, piano, pile, room or tennis with the given arguments:
#   demos/run.sh
#   demos/run.sh tennis --profile 5
# or plaza, a square for very many people over a NATS server, which it starts unless --server names one:
#   demos/run.sh plaza --people 200
# or opens rooms in the browser and prints a link to join (docs/room.md). TANDEM_ROOM_PAGE, a folder or archive of a
# release's page, replaces emscripten:
#   demos/run.sh room-link
# or draws key frames of all of them as PNG (needs Chromium):
#   demos/run.sh --pictures docs/img
# or the robots of docs/robots.md, from clones of the repositories that it names (also needs MuJoCo and urdfdom):
#   demos/run.sh --robots FOLDER
# or README's moving picture (also needs Debian's webp):
#   demos/run.sh --moving-picture docs/img/piano.webp
# Results go to standard output, the build's messages to standard error.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# The page's build packages are needed only for the page.
packages=()
for argument in "$@"; do
  [[ $argument != --view* && $argument != --*picture* ]] || packages=(--with-view)
  [[ $argument != --robots ]] || packages=(--with-view --with-robots)
done

build() {
  bash "$root/cmake/install-deps.sh" "${packages[@]}" >&2
  (
    cd "$root"
    cmake --preset release >&2
    cmake --build --preset release --target "$@" >&2
  )
}

run_plaza() {
  bash "$root/cmake/install-deps.sh" --with-cluster >&2
  (
    cd "$root"
    cmake --preset release -B build/nats -DTANDEM_WITH_NATS=ON -DTANDEM_BUILD_BENCHMARKS=OFF >&2
    cmake --build build/nats --target plaza >&2
  )
  if [[ " $* " == *" --server"* ]]; then
    "$root/build/nats/bin/plaza" "$@"
    return
  fi
  local folder server address
  folder=$(mktemp -d)
  # Debian installs it outside users' PATH.
  PATH=$PATH:/usr/sbin nats-server -a 127.0.0.1 -p -1 -js -sd "$folder" --ports_file_dir "$folder" \
    2>"$folder/log" &
  server=$!
  trap 'kill '"$server"' 2>/dev/null; wait '"$server"' 2>/dev/null; rm -rf "'"$folder"'"' EXIT
  for _ in {1..100}; do
    address=$(sed -n 's/.*"nats": *\["nats:..\([^"]*\)".*/\1/p' "$folder"/*.ports 2>/dev/null || true)
    [[ -z $address ]] || break
    sleep 0.1
  done
  if [[ -z $address ]]; then
    cat "$folder/log" >&2
    return 1
  fi
  "$root/build/nats/bin/plaza" --server "$address" "$@"
}

# The page is built unless TANDEM_ROOM_PAGE names a folder or a release's archive.
run_room_link() {
  local page=${TANDEM_ROOM_PAGE:-$root/build/web/room}
  if [[ -z ${TANDEM_ROOM_PAGE:-} ]]; then
    bash "$root/cmake/install-deps.sh" --with-view --with-web >&2
    bash "$root/bindings/web/fetch-sources.sh" "$root/build/web_sources" >&2
  else
    bash "$root/cmake/install-deps.sh" --with-view >&2
  fi
  if [[ $page == *.tar.gz ]]; then
    rm -rf "$root/build/room_page"  # of another release
    mkdir -p "$root/build/room_page"
    tar -C "$root/build/room_page" --strip-components 1 -xzf "$page"
    page=$root/build/room_page
  fi
  (
    cd "$root"
    if [[ -z ${TANDEM_ROOM_PAGE:-} ]]; then
      export NODE_PATH=/usr/share/nodejs
      env -u CMAKE_CXX_COMPILER_LAUNCHER cmake --preset web >&2
      cmake --build --preset web --target tandem_room_page >&2
    fi
    cmake --preset release -B build/room -DTANDEM_BUILD_ROOM=ON -DTANDEM_BUILD_BENCHMARKS=OFF >&2
    cmake --build build/room --target tandem-room >&2
  )
  exec "$root/build/room/bin/tandem-room" --page "$page" "$@"
}

# A build of its own, as other programs do without the readers of robots.
build_scene_view() {
  bash "$root/cmake/install-deps.sh" "${packages[@]}" >&2
  (
    cd "$root"
    cmake --preset release -B build/robots -DTANDEM_WITH_URDF=ON -DTANDEM_WITH_MJCF=ON \
      -DTANDEM_BUILD_BENCHMARKS=OFF >&2
    cmake --build build/robots --target scene_view >&2
  )
}

# NODE_SCRIPT ARGUMENT..., with the programs of TANDEM_BIN, or the demos', and a browser.
draw() {
  npm --prefix "$root/tests/view" ci --no-audit --no-fund >&2
  TANDEM_BIN=${TANDEM_BIN:-$root/build/release/bin} exec node "$root/tests/view/$1" "${@:2}"
}

case ${1:-} in
  -h | --help)
    # Prints the header of this file.
    sed -n '5,/^set /{s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
    echo "What a demo takes: demos/run.sh cubes --help"
    exit
    ;;
  --pictures)
    build cliff cubes piano pile room tennis
    draw pictures.mjs "$(realpath -m "${2:-pictures}")" "${@:3}"
    ;;
  --robots)
    [[ $# -ge 2 ]] || { echo "run.sh: --robots needs the folder of the repositories" >&2; exit 2; }
    build_scene_view
    TANDEM_BIN=$root/build/robots/bin
    draw robots.mjs "$(realpath "$2")" "$root/docs/img/robots" "${@:3}"
    ;;
  --moving-picture)
    build piano
    draw moving_picture.mjs "$(realpath -m "${2:-piano.webp}")" "${@:3}"
    ;;
esac

[[ $# -gt 0 ]] || set -- piano --profile 4
demo=piano
if [[ $1 != -* ]]; then
  demo=$1
  shift
fi
case $demo in
  cliff | cubes | piano | pile | room | tennis)
    build "$demo"
    exec "$root/build/release/bin/$demo" "$@"
    ;;
  plaza) run_plaza "$@" ;;
  room-link) run_room_link "$@" ;;
  *)
    echo "run.sh: unknown demo '$demo'; it must be cliff, cubes, piano, pile, plaza, room, room-link or tennis" >&2
    exit 2
    ;;
esac
