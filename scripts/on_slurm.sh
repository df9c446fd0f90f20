#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# on_slurm.sh PROGRAM ARGUMENTS...: runs a program on a node of a Slurm cluster, as in `make map LAUNCH=scripts/on_slurm.sh`:
# within an allocation (salloc) as a step of it, else as a Slurm job of its own. lists/needs.txt (step_needs.py) says what
# cores, memory and time its job takes; srun's own variables, as SLURM_PARTITION, add to them.
# A program that ends says so in a file. Where it says nothing, its node was lost or Slurm ended it: it begins again, where there is
# room, with twice the time; one that a signal killed, with twice the memory. (Outputs are renamed into place when they are whole, and
# are the same bytes wherever they are made: a lost node that still works does no harm.)
set -u
# When a signal ends make and run_job.sh, this ends too, and its step with it.
[ -n "${NIGHTMAP_ENDS_WITH_JOB:-}" ] || NIGHTMAP_ENDS_WITH_JOB=1 exec setpriv --pdeathsig TERM -- "$0" "$@"
: "${NIGHTMAP_SITE_DIR:?run_job.sh sets it}" "${NIGHTMAP_RULE:?run_job.sh sets it}"
command -v srun >/dev/null || { echo "nightmap: no srun here: install Slurm's client (slurm-client), or make without LAUNCH" >&2; exit 2; }
attempts=3
ended=$NIGHTMAP_SITE_DIR/logs/$NIGHTMAP_RULE.ended
cores=$THREADS memory_mb=4000 minutes=0 known=''
while read -r job job_cores job_memory_mb job_minutes; do
  if [[ $NIGHTMAP_RULE == "$job" || $NIGHTMAP_RULE == "$job"_* ]] && ((${#job} > ${#known})); then
    known=$job cores=$job_cores memory_mb=$job_memory_mb minutes=$job_minutes
  fi
done <"$NIGHTMAP_SITE_DIR/lists/needs.txt"

# On the node: ON_NODE FILE PROGRAM ARGUMENTS...
# shellcheck disable=SC2016 # the node's shell expands it
on_node='ended=$1; shift; echo "on ${SLURMD_NODENAME:-$HOSTNAME}" >>"$ended"; "$@"; code=$?; echo "$code" >>"$ended"; exit "$code"'
stop='' step='' # the step runs in the background, where Ctrl-C does not reach it
trap 'stop=130; [ -z "$step" ] || kill "$step"' INT
trap 'stop=143; [ -z "$step" ] || kill "$step"' TERM HUP
rm -f "$ended".* # of a make that was killed
for ((attempt = 1; ; ++attempt)); do
  file=$ended.$$.$attempt # so that a lost node that still works writes into no later one's
  : >"$file" # nodes add to it: a name that is known to be missing may stay so for long on a shared file system
  time=()
  ((minutes == 0)) || time=(--time="$minutes")
  srun --quiet --unbuffered --nodes=1 --ntasks=1 --cpus-per-task="$cores" --mem="$memory_mb" "${time[@]}" \
    ${SLURM_JOB_ID:+--exact} --job-name="${NIGHTMAP_SITE_DIR##*/}:$NIGHTMAP_RULE" --kill-on-bad-exit=1 \
    bash -c "$on_node" on_node "$file" "$@" </dev/null &
  step=$!
  [ -z "$stop" ] || kill "$step"
  wait "$step"
  code=$?
  [ -z "$stop" ] || { wait "$step" 2>/dev/null; rm -f "$ended".*; exit "$stop"; }
  { read -r _ node && read -r own; } <"$file" || own=''
  case ${own:-none} in
    none | 143) said="Slurm ended it, or lost its node ${node:-} (srun: exit code $code)" minutes=$((2 * minutes)) ;;
    137) said="it was killed by signal 9 on ${node:-}, as where memory runs out; it gets $((memory_mb *= 2)) MB" ;;
    *) rm -f "$ended".*; exit "$own" ;;
  esac
  ((attempt < attempts)) || break
  echo "nightmap: $NIGHTMAP_RULE: $said: attempt $((attempt + 1)) of $attempts" >&2
  sleep "$((attempt * 2 - 1))"
  [ -z "$stop" ] || { rm -f "$ended".*; exit "$stop"; }
done
rm -f "$ended".*
echo "nightmap: $NIGHTMAP_RULE: $said, $attempts times: sinfo shows the nodes, scontrol show job their reasons" >&2
[ "$own" = 137 ] && exit 137
exit 1
