#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Stands for any program of a job, in tests of the rules: it reads nothing and writes outputs of its arguments' names.
# The lists have STUB_SHARDS shards and STUB_TILES tiles; the job STUB_FAILS fails with exit code 1. Files that it writes
# beside its outputs stay the same, or are other at each run with STUB_CHANGES.
# It starts no other program: a test runs thousands of stubs.
case " $* " in *" --check-config "*) exit 0 ;; esac
program=${0##*/}
TZ=UTC printf -v start_time '%(%Y-%m-%dT%H:%M:%SZ)T' -1
[ "$program" = "${STUB_FAILS:-}" ] && { echo "00:00:00 error $program: made to fail"; exit 1; }
keep() { # keep FILE LINE: writes it unless it is there, or with the time
  local present=
  [ -f "$1" ] && IFS= read -r -d '' present <"$1"
  [ -z "${STUB_CHANGES:-}" ] && [[ $present = "$2"[[:space:]]* ]] || printf '%s\n' "$2${STUB_CHANGES:+ $EPOCHREALTIME}" >"$1"
}
receipt='' config='' outputs=()
while [ $# -gt 0 ]; do
  case "$1" in
    --config) config=$2 ;;
    --out) case "$2" in receipt=*) receipt=${2#*=} ;; *) outputs+=("${2#*=}") ;; esac ;;
  esac
  shift
done
folder=${receipt%/*}
case $receipt in *_[0-9][0-9][0-9][0-9].json) for ((i = 0; i < ${STUB_STEPS:-0}; ++i)); do :; done ;; esac # work of a shard
quoted='' # the text of the config as JSON has it
if [ -n "$config" ]; then
  IFS= read -r -d '' quoted <"$config"
  quoted=${quoted%$'\n'}
  quoted=${quoted//\\/\\\\}
  quoted=${quoted//\"/\\\"}
  quoted=${quoted//$'\n'/\\n}
fi
list() { # list KIND NAME...: a list of units as the programs write it
  printf 'nightmap %s, version 1, %d names\n' "$1" $(($# - 1))
  shift
  printf '%s\n' "$@"
}
numbered() { # numbered FORMAT NUMBER: names from 0 on
  local i name
  names=()
  for ((i = 0; i < $2; ++i)); do
    # shellcheck disable=SC2059 # the format is the argument
    printf -v name "$1" "$i"
    names+=("$name")
  done
}
for path in "${outputs[@]}"; do
  case "$path" in
    */shards.txt)
      numbered %04d "${STUB_SHARDS:-3}"
      list shards "${names[@]}" >"$path"
      for name in "${names[@]}"; do keep "$folder/shard_$name.csv" "frames of $name"; done
      keep "$folder/cameras.json" '{}'
      for name in held_out.csv held_out.tum acceleration.h5 odometry.h5 scans.h5; do keep "$folder/$name" "$name"; done
      ;;
    */queries.txt)
      list queries a.jpg >"$path"
      case "$program" in
        scan_queries) keep "$folder/queries.h5" queries ;;
        *) keep "$folder/queries.csv" $'query_idx\n0' && keep "$folder/query_cameras.json" '{}' ;;
      esac
      ;;
    */tiles.txt)
      numbered %d_0 "${STUB_TILES:-2}"
      list tiles "${names[@]}" >"$path"
      for name in "${names[@]}"; do keep "$folder/tile_$name.json" '{}'; done
      keep "$folder/cameras.json" '{}'
      ;;
    */floors.json)
      echo '{"format": "nightmap floors", "version": 2, "floors": [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"}]}' >"$path"
      ;;
    */localize/queries.csv)
      echo 'color_path,status,reason,tx_m,ty_m,tz_m,qx,qy,qz,qw,position_sigma_m,rotation_sigma_deg' >"$path"
      ;;
    */voxel_labels/legend.json) echo "$program" >"$path" && keep "$folder/voxels.h5" voxels ;;
    *report*.json) printf '%s\n' "{\"format\": \"nightmap report\", \"version\": 1, \"stage\": \"$program\", \"num_skipped\": 0, \"skipped\": [], \"config\": \"$quoted\"}" >"$path" ;;
    *)
      [ -d "${path%/*}" ] || mkdir -p "${path%/*}"
      echo "$program" >"$path"
      ;;
  esac
done
entries=''
for path in "${outputs[@]}"; do entries+="${entries:+, }{\"name\": \"out\", \"path\": \"$path\"}"; done
printf '%s\n' "{\"format\": \"nightmap receipt\", \"version\": 1, \"stage\": \"$program\", \"start_time\": \"$start_time\", \"config\": \"$quoted\", \"inputs\": [], \"outputs\": [$entries], \"wall_time_s\": 0.1, \"cpu_time_s\": 0.1
}" >"$receipt"
