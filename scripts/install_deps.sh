#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian 12 packages that are missing, of those that nightmap needs for what the arguments name: stage
# programs, `colmap`, `tests` (with those of all programs and colmap), `lint`. Packages that every program needs are
# always among them. Without arguments: all packages. --quiet says nothing when none is missing.
set -euo pipefail

is_quiet=
if [[ ${1:-} == --quiet ]]; then
  is_quiet=1
  shift
fi

packages=(
  build-essential      # gcc 12, libc
  cmake ninja-build    # the build
  ccache               # makes a repeated build take seconds
  lld                  # linking: the only linker that drops libraries that only unused functions need
  git make
  python3              # config resolution, evaluation, end-to-end tests
  python3-numpy        # evaluation
  python3-h5py         # evaluation: HDF5 artifacts
  python3-matplotlib   # report: plots
  python3-scipy        # evaluation: parts of pictures that hang together, chi-square
  python3-yaml         # the picture that a ROS map names
  python3-pil          # report: thumbnails of query pictures
  libjs-three          # report: the map in space, three.js r111 (Debian 12)
  libeigen3-dev        # geometry
  libopencv-dev        # descriptors, optical flow, P3P, videos, drawing
  libceres-dev         # pose graph
  libsuitesparse-dev   # bundle adjustment: sparse Cholesky factorization
  libnanoflann-dev     # localize: nearest landmarks in space
  liboctomap-dev       # octree
  libpng-dev libturbojpeg0-dev  # pictures
  libopenimageio-dev   # pictures of other formats
  openimageio-tools    # the CMake files of libopenimageio-dev require its programs; we use none
  libgif-dev           # drive: animations in exact colors
  libhdf5-dev          # array artifacts
  zlib1g-dev           # sensor logs, which are often gzipped
  libsqlite3-dev       # COLMAP database
  libtomlplusplus-dev  # configs
  libyaml-cpp-dev      # ROS maps, and object features, which people edit by hand
  libcli11-dev         # command lines
  libspdlog-dev        # log
  libfmt-dev           # text
  nlohmann-json3-dev   # reports, receipts
  libxxhash-dev        # hashes in receipts
)
for_point_clouds=(
  libpcl-dev           # mesh, scan_localize, things: marching cubes, closest points, clusters, voxel filter
)
for_made_up_recordings=(
  libembree-dev        # synthetic world: ray casting
)
for_colmap=(
  colmap               # tests: opens the exported model; make evaluate-colmap runs it
)
for_lint=(
  clang-format         # make format, format-check
  clang-tidy           # make lint
  libclang-dev llvm-dev  # make lint: its plugin of clang-tidy
  shellcheck           # make lint
)
for_tests=(
  assimp-utils         # tests: assimp opens the exported mesh
  chromium             # tests: opens the report
  gdal-bin             # tests: opens the floor plans
  octomap-tools        # tests: convert_octree reads our octrees
  libgtest-dev libgmock-dev  # unit tests
  slurmctld slurmd slurm-client munge  # tests: a cluster on this machine
)

[[ $# -gt 0 ]] || set -- tests lint
for what; do
  case $what in
    mesh | scan_localize | things) packages+=("${for_point_clouds[@]}") ;;
    synthesize | synthesize_ceiling) packages+=("${for_made_up_recordings[@]}") ;;
    colmap) packages+=("${for_colmap[@]}") ;;
    tests) packages+=("${for_point_clouds[@]}" "${for_made_up_recordings[@]}" "${for_colmap[@]}" "${for_tests[@]}") ;;
    lint) packages+=("${for_lint[@]}") ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  [[ $is_quiet ]] || echo "dependencies: all ${#packages[@]} packages are installed"
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
