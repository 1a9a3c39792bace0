#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
#
# Installs the Debian packages that Tandem needs, those that are missing only; says nothing where
# none is.
#   cmake/install-deps.sh [--with-view] [--with-checks] [--with-benchmarks] [--with-ice]
#     [--with-cluster] [--with-python] [--with-csharp] [--with-robots] [--with-web] [--with-cross]
# with --with-view also what the demos' page is built with (docs/view.md), with --with-checks what
# .ci/run needs, with --with-benchmarks what the benchmarks compare with and draw with, with --with-ice
# what TANDEM_WITH_ICE and its tests need, with --with-cluster what TANDEM_WITH_MPI, TANDEM_WITH_NATS and
# their tests need (docs/scale.md), with --with-python what TANDEM_BUILD_PYTHON and its tests
# need, with --with-csharp what TANDEM_BUILD_CSHARP and its tests need (docs/csharp.md), with
# --with-robots what TANDEM_WITH_URDF and TANDEM_WITH_MJCF need (docs/scene_files.md), with
# --with-web what the package for browsers is built and tested with (docs/web.md), with --with-cross what
# Tandem for 64 bit ARM, Windows and libc++ is built with and runs on (docs/platforms.md); all is built without it, too,
# and shows or does less.
# Without root (or sudo without a password) or without apt-get it names them and exits with 1.
set -euo pipefail

packages=(
  build-essential cmake ninja-build
  libeigen3-dev libxsimd-dev libccd-dev libfcl-dev libtinyobjloader-dev libasio-dev
  pkgconf libsodium-dev libtomlplusplus-dev libboost-dev libtinygltf-dev nlohmann-json3-dev
  catch2
)
with_view() {
  # A newer Node.js than Debian's, where there is one, would not bear Debian's npm beside it.
  command -v node >/dev/null || packages+=(nodejs)
  command -v npm >/dev/null || packages+=(npm)
}

for argument in "$@"; do
  case "$argument" in
    --with-python) packages+=(pybind11-dev python3-dev python3-numpy python3-pip python3-pytest mypy) ;;
    --with-csharp)
      packages+=(mono-mcs mono-runtime libmono-system4.0-cil libmono-system-core4.0-cil binutils python3) ;;
    --with-robots)
      packages+=(liburdfdom-dev libtinyxml-dev libmujoco-dev libqhull-dev python3-jsonschema) ;;
    --with-view) with_view ;;
    --with-cross)
      packages+=(g++-aarch64-linux-gnu qemu-user g++-mingw-w64-x86-64-posix wine wine64 dpkg-dev clang
        autoconf automake libtool clang-19 libc++-19-dev libc++abi-19-dev) ;;
    --with-web)
      packages+=(emscripten node-acorn dpkg-dev clang)
      command -v node >/dev/null || packages+=(nodejs)
      ;;
    --with-checks)
      packages+=(ccache clang clang-format clang-tidy libclang-rt-14-dev python3-clang-14 doxygen python3 git iproute2)
      with_view
      command -v chromium >/dev/null || packages+=(chromium)
      ;;
    --with-benchmarks) packages+=(pkgconf libbullet-dev libbenchmark-dev python3 python3-matplotlib python3-scour) ;;
    --with-ice) packages+=(libnice-dev coturn nftables iproute2) ;;
    --with-cluster)
      packages+=(libopenmpi-dev openmpi-bin libtrilinos-zoltan-dev nats-server libnats-dev) ;;
    *)
      echo "install-deps: unknown argument: $argument" >&2
      exit 2
      ;;
  esac
done

missing=()
if command -v dpkg-query >/dev/null; then
  for package in "${packages[@]}"; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $status == installed ]] || missing+=("$package")
  done
else
  echo "install-deps: no dpkg here, so these Debian packages (or their like) cannot be looked for:" >&2
  echo "  ${packages[*]}" >&2
  exit 1
fi
[[ ${#missing[@]} -gt 0 ]] || exit 0

refuse() {
  echo "install-deps: $1. Missing packages:" >&2
  echo "  ${missing[*]}" >&2
  exit 1
}

command -v apt-get >/dev/null || refuse "there is no apt-get"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null && sudo -n true 2>/dev/null || refuse "this needs root"
  as_root=(sudo -n)
fi

apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0)

log=$(mktemp)
trap 'rm -f "$log"' EXIT
install_missing() {
  "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >"$log" 2>&1 </dev/null
}

echo "install-deps: installing ${missing[*]}"
# The lists of packages may be absent or old: look at them only where it does not work without.
if ! install_missing; then
  "${apt[@]}" update >"$log" 2>&1 </dev/null || {
    cat "$log" >&2
    refuse "apt-get update failed"
  }
  install_missing || {
    cat "$log" >&2
    refuse "apt-get install failed"
  }
fi
