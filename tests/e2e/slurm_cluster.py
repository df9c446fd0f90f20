# SPDX-License-Identifier: Apache-2.0
"""A Slurm cluster of two nodes on this machine: munged, slurmctld and two slurmd, on the loopback interface alone, with keys, logs and state
in a temporary folder. All that it starts ends with it. A node can be lost as by a power failure: its daemon, its steps and their programs."""
import ctypes
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

NODES = ("n1", "n2")
PROGRAMS = ("munged", "slurmctld", "slurmd", "srun", "salloc")
PATH = f"{os.environ['PATH']}:/usr/sbin:/sbin"
PR_SET_CHILD_SUBREAPER = 36
START_S = 30
CONFIG = """\
ClusterName=nightmap
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=5
KillWait=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=2 RealMemory=12000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=2 RealMemory=12000
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def missing_programs():
    return [program for program in PROGRAMS if not shutil.which(program, path=PATH)]


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def adopt_orphans():
    """Processes that a daemon starts and leaves stay below it, so that all of a node can be found."""
    os.setsid()
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def processes_below(pid):
    """A process and all that it started, from /proc."""
    children = {}
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(path.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        children.setdefault(parent, []).append(int(path.parent.name))
    found = [pid]
    for one in found:
        found += children.get(one, [])
    return found


class Cluster:
    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-slurm-"))
        self.log = open(self.folder / "log.txt", "w+", encoding="utf-8")
        self.environment = {"SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": PATH}
        self.running = {}
        try:
            self._start()
        except BaseException:
            self.stop()
            raise

    def _start(self):
        if missing_programs():
            raise AssertionError(f"no {', '.join(missing_programs())}: run scripts/install_deps.sh tests")
        (self.folder / "state").mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        (self.folder / "slurm.conf").write_text(CONFIG.format(
            host=socket.gethostname().split(".")[0], user=pwd.getpwuid(os.getuid()).pw_name, folder=self.folder, ports=free_ports(3)))
        munge = {name: self.folder / f"munge.{name}" for name in ("socket", "pid-file", "log-file", "seed-file")}
        self._run("munged", "--foreground", "--force", "--key-file", key, *(word for name, path in munge.items() for word in (f"--{name}", path)))
        self._wait_for(munge["socket"].exists)
        self._run("slurmctld", "-D", "-c", "-f", self.environment["SLURM_CONF"])
        for node in NODES:
            self._run("slurmd", "-D", "-N", node, "-f", self.environment["SLURM_CONF"], name=node)
        self._wait_for(lambda: self.states() == {node: "idle" for node in NODES})

    def _run(self, program, *arguments, name=None):
        self.running[name or program] = subprocess.Popen(
            [shutil.which(program, path=PATH), *map(str, arguments)], env=os.environ | self.environment, stdin=subprocess.DEVNULL,
            stdout=self.log, stderr=self.log, preexec_fn=adopt_orphans)  # fmt: skip

    def _wait_for(self, condition):
        until = time.monotonic() + START_S
        while not condition():
            ended = [name for name, process in self.running.items() if process.poll() is not None]
            if ended or time.monotonic() > until:
                self.log.seek(0)
                raise AssertionError(f"the cluster did not start ({', '.join(ended) or 'in time'}):\n{self.log.read()[-4000:]}")
            time.sleep(0.1)

    def states(self):
        """Node -> its state, as sinfo has it; nothing while the controller does not answer."""
        words = subprocess.run(["sinfo", "--noheader", "--Node", "--format=%N %T"], env=os.environ | self.environment, text=True,
                               capture_output=True).stdout.split()
        return dict(zip(words[::2], words[1::2]))

    def lose(self, node):
        """All processes of a node are gone at once."""
        pids = processes_below(self.running.pop(node).pid)
        for pid in pids:  # stopped first, so that none sees another's end
            _send(pid, signal.SIGSTOP)
        for pid in [*pids, *processes_below(pids[0])]:
            _send(pid, signal.SIGKILL)

    def stop(self):
        for process in reversed(self.running.values()):
            for pid in reversed(processes_below(process.pid)):
                _send(pid, signal.SIGKILL)
            process.wait()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def _send(pid, number):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


if __name__ == "__main__":
    cluster = Cluster()
    try:
        print(f"SLURM_CONF={cluster.environment['SLURM_CONF']}", flush=True)
        sys.stdin.read()
    finally:
        cluster.stop()
