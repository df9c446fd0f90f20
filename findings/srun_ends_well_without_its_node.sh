#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# srun of Slurm 22.05.8 (Debian 12: slurm-client 22.05.8-4+deb12u3) ends with exit code 0 when the only node of its job is lost. The task never
# came to its end; srun writes "Node failure on n2" to its error output, Slurm has the job as NODE_FAIL, and a script that looks at srun's exit code
# takes the work as done. A task that ends while its node is there gives its own exit code. So whoever runs programs by srun needs another
# sign of their end, as a file that the task writes last.
set -eu
folder=$(mktemp -d)
export MARK=$folder/head
marked() { grep -lsz "^MARK=$1" /proc/[0-9]*/environ | cut -d/ -f3; }
steps() { find /proc/[0-9]*/exe -lname "$folder/*/slurmstepd-wlm" 2>/dev/null | cut -d/ -f3; } # whose title hides the mark
end() {
  for pid in $(marked "$folder") $(steps); do [ "$pid" = $$ ] || kill -9 "$pid" 2>/dev/null || true; done
  rm -rf "$folder"
}
trap end EXIT
cd "$folder"
version=22.05.8-4+deb12u3
apt-get download -qq slurmctld=$version slurmd=$version slurm-client=$version slurm-wlm-basic-plugins=$version munge=0.5.15-2+deb12u1 libmunge2=0.5.15-2+deb12u1 >/dev/null 2>&1
for package in *.deb; do dpkg -x "$package" tree; done
libraries=$folder/tree/usr/lib/x86_64-linux-gnu
export PATH=$folder/tree/usr/sbin:$folder/tree/usr/bin:$PATH LD_LIBRARY_PATH=$libraries:$libraries/slurm-wlm SLURM_CONF=$folder/slurm.conf
head -c 1024 /dev/urandom >munge.key
chmod 400 munge.key
mkdir state
cat >slurm.conf <<CONF
ClusterName=finding
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=17817
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
PluginDir=$libraries/slurm-wlm
AuthInfo=socket=$folder/munge.socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SlurmdTimeout=5
NodeName=n1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=17818
NodeName=n2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=17819
PartitionName=main Nodes=n1,n2 Default=YES State=UP
CONF
munged --foreground --force --key-file "$folder/munge.key" --socket "$folder/munge.socket" --pid-file "$folder/munge.pid" \
  --log-file "$folder/munge.log" --seed-file "$folder/munge.seed" 2>/dev/null &
sleep 1
slurmctld -D -c >slurmctld.log 2>&1 &
for node in n1 n2; do MARK=$folder/$node slurmd -D -N $node -d "$(find "$folder/tree" -name slurmstepd-wlm)" >$node.log 2>&1 & done
until [ "$(sinfo --noheader --format=%T 2>/dev/null)" = idle ]; do sleep 1; done
{
  srun --version
  code=0
  srun --nodelist=n1 sh -c 'exit 7' 2>/dev/null || code=$?
  echo "task ended with 7: srun ends with $code"
  srun --export=ALL,MARK="$folder/n2" --nodelist=n2 sh -c 'sleep 300; touch ended' 2>srun.log &
  srun=$!
  sleep 5
  for pid in $(marked "$folder/n2") $(steps); do kill -9 "$pid" 2>/dev/null || true; done
  code=0
  wait $srun || code=$?
  echo "task ended: $([ -e ended ] && echo yes || echo no)"
  grep -o 'Node failure on n2' srun.log | sort -u
  echo "node lost: srun ends with $code"
} >seen
cat seen
cat >expected <<'TXT'
slurm-wlm 22.05.8
task ended with 7: srun ends with 7
task ended: no
Node failure on n2
node lost: srun ends with 0
TXT
cmp seen expected
