#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run_job.sh SITE_FOLDER JOB COMMAND...: runs the command of a rule and returns its exit code. Writes its messages
# to the terminal and to logs/JOB.log, its begin and end to logs/journal.txt.
set -u
site=$1 job=$2
shift 2
logs=$site/logs
journal() { printf '%(%s)T %s %s\n' -1 "$job" "$*" >>"$logs/journal.txt"; }
echo "== $job"
journal begin
"$@" 2>&1 | tee "$logs/$job.log"
code=${PIPESTATUS[0]}
if [ "$code" -ne 0 ]; then
  echo "nightmap: $job failed, exit code $code" | tee -a "$logs/$job.log" >&2
fi
journal "end $code"
exit "$code"
