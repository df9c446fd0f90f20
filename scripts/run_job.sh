#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run_job.sh SITE_FOLDER JOB COMMAND...: runs the command of a rule and returns its exit code. Writes its messages
# to the terminal and to logs/JOB.log, its begin and end to logs/journal.txt.
set -u
site=$1 job=$2
shift 2
logs=$site/logs
export NIGHTMAP_SITE_DIR=$site NIGHTMAP_RULE=$job # for a program in LAUNCH
# Words of the loader and libraries, the last of a thread without room for its stack.
says_memory='failed to map segment|[Cc]annot allocate memory|bad_alloc|Resource temporarily unavailable'
# A program that memory fails before its main begins, or that the kernel ends, cannot say so itself.
lack_of_memory() {
  case $code in
  126 | 127 | 134) grep -qE "$says_memory" "$logs/$job.log" && echo "out of memory" ;;
  137) echo "killed by signal 9, as the kernel does where memory runs out" ;;
  139) [ "$(ulimit -v)" = unlimited ] || echo "ended by signal 11, as libraries do that are given no memory" ;;
  esac
}
journal() { printf '%(%s)T %s %s\n' -1 "$job" "$*" >>"$logs/journal.txt"; }
echo "== $job"
journal begin
"$@" 2>&1 | tee "$logs/$job.log"
code=${PIPESTATUS[0]}
if [ "$code" -ne 0 ]; then
  lack=$(lack_of_memory)
  if [ -n "$lack" ]; then
    echo "nightmap: $job: $lack (ulimit -v: $(ulimit -v)); raise the limit, free memory or set THREADS=1, and run make again" |
      tee -a "$logs/$job.log" >&2
  fi
  echo "nightmap: $job failed, exit code $code" | tee -a "$logs/$job.log" >&2
fi
journal "end $code"
exit "$code"
