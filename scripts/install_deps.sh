#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian 12 packages that nightmap needs to build, test and run. Does nothing when all are
# installed.
set -euo pipefail

packages=(
  build-essential      # gcc 12, libc
  cmake ninja-build    # the build
  ccache               # makes a repeated build take seconds
  clang-format         # make format, format-check
  clang-tidy           # make lint
  lld                  # linking: the only linker that drops libraries that only unused functions need
  shellcheck           # make lint
  git make
  python3              # config resolution, evaluation, end-to-end tests
  python3-numpy        # evaluation
  python3-h5py         # evaluation: HDF5 artifacts
  python3-matplotlib   # report: plots
  python3-pil          # report: thumbnails of query pictures
  chromium             # tests: opens the report
  libeigen3-dev        # geometry
  libopencv-dev        # descriptors, optical flow, P3P, videos, drawing
  libceres-dev         # pose graph
  libsuitesparse-dev   # bundle adjustment: sparse Cholesky factorization
  libpcl-dev           # scan_localize: iterative closest points, voxel filter
  libnanoflann-dev     # localize: nearest landmarks in space
  liboctomap-dev       # octree
  octomap-tools        # tests: convert_octree reads our octrees
  libopenimageio-dev   # reading and writing pictures
  openimageio-tools    # the CMake files of libopenimageio-dev require its programs; we use none
  libgif-dev           # drive: animations in exact colors
  libembree-dev        # synthetic world: ray casting
  libhdf5-dev          # array artifacts
  zlib1g-dev           # sensor logs, which are often gzipped
  libsqlite3-dev       # COLMAP database
  colmap               # tests: opens the exported model; make evaluate-colmap runs it
  libtomlplusplus-dev  # configs
  libyaml-cpp-dev      # object features, which people edit by hand
  libcli11-dev         # command lines
  libspdlog-dev        # log
  libfmt-dev           # text
  nlohmann-json3-dev   # reports, receipts
  libxxhash-dev        # hashes in receipts
  libgtest-dev libgmock-dev  # unit tests
)

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "dependencies: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || {
    echo "install_deps.sh: not root and no sudo; ask an administrator to run: apt-get install ${missing[*]}" >&2
    exit 1
  }
  as_root=(sudo)
fi
command -v apt-get >/dev/null || {
  echo "install_deps.sh: found no apt-get; nightmap is built on Debian 12. Install by other means: ${missing[*]}" >&2
  exit 1
}
echo "dependencies: installing ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends "${missing[@]}"
