#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Stands for any program of a job, in tests of the rules: it reads nothing and writes outputs of its arguments' names.
# The lists have STUB_SHARDS shards and STUB_TILES tiles; the job STUB_FAILS fails with exit code 1.
program=${0##*/}
start_time=$(date -u +%Y-%m-%dT%H:%M:%SZ)
case " $* " in *" --check-config "*) exit 0 ;; esac
[ "$program" = "${STUB_FAILS:-}" ] && { echo "00:00:00 error $program: made to fail"; exit 1; }
keep() { [ -f "$1" ] && [ "$(cat "$1")" = "$2" ] || printf '%s\n' "$2" >"$1"; }
quoted() { sed 's/\\/\\\\/g; s/"/\\"/g' "$1" | sed ':a; N; $!ba; s/\n/\\n/g'; }
receipt=''
config=''
outputs=''
while [ $# -gt 0 ]; do
  case "$1" in
    --config) config=$2 ;;
    --out)
      path=${2#*=}
      case "$2" in receipt=*) receipt=$path ;; *) outputs="$outputs $path" ;; esac
      ;;
  esac
  shift
done
folder=${receipt%/*}
list() { # list KIND NAMES: a list of units as the programs write it
  printf 'nightmap %s, version 1, %d names\n' "$1" "$(printf '%s\n' "$2" | wc -l)"
  printf '%s\n' "$2"
}
for path in $outputs; do
  case "$path" in
    */shards.txt)
      names=$(seq -f %04g 0 $((${STUB_SHARDS:-3} - 1)))
      list shards "$names" >"$path"
      for name in $names; do keep "$folder/shard_$name.csv" "frames of $name"; done
      keep "$folder/cameras.json" '{}'
      for name in held_out.csv held_out.tum acceleration.h5 odometry.h5 scans.h5; do keep "$folder/$name" "$name"; done
      ;;
    */queries.txt)
      echo 'nightmap queries, version 1, 1 names' >"$path"
      case "$program" in
        scan_queries) keep "$folder/queries.h5" queries ;;
        *) keep "$folder/queries.csv" 'query_idx
0' && keep "$folder/query_cameras.json" '{}' ;;
      esac
      ;;
    */tiles.txt)
      names=$(seq -f '%g_0' 0 $((${STUB_TILES:-2} - 1)))
      list tiles "$names" >"$path"
      for name in $names; do keep "$folder/tile_$name.json" '{}'; done
      keep "$folder/cameras.json" '{}'
      ;;
    */floors.json)
      echo '{"format": "nightmap floors", "version": 2, "floors": [{"number": 0, "height_m": 0.0, "yaml": "map.yaml"}]}' >"$path"
      ;;
    */voxel_labels/legend.json) echo "$program" >"$path" && keep "$folder/voxels.h5" voxels ;;
    *report*.json) printf '%s\n' "{\"format\": \"nightmap report\", \"version\": 1, \"stage\": \"$program\", \"num_skipped\": 0, \"skipped\": [], \"config\": \"$(quoted "$config")\"}" >"$path" ;;
    *) mkdir -p "${path%/*}" && echo "$program" >"$path" ;;
  esac
done
entries=''
for path in $outputs; do entries="$entries${entries:+, }{\"name\": \"out\", \"path\": \"$path\"}"; done
printf '%s\n' "{\"format\": \"nightmap receipt\", \"version\": 1, \"stage\": \"$program\", \"start_time\": \"$start_time\", \"config\": \"$(quoted "$config")\", \"inputs\": [], \"outputs\": [$entries], \"wall_time_s\": 0.1, \"cpu_time_s\": 0.1
}" >"$receipt"
