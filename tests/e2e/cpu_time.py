# SPDX-License-Identifier: Apache-2.0
"""CPU time of what a test starts: unlike wall time, it does not grow when other programs keep the machine busy."""
import resource
import subprocess

# Loops for about 0.05 s: what a test's bound is a multiple of, so that it holds on slow machines and on fast ones.
YARDSTICK = ["/usr/bin/python3", "-I", "-S", "-c", "n = 0\nfor i in range(10**6): n += i % 7"]


def cpu_time_s(body):
    """CPU seconds of the programs that `body` starts and waits for, and of those that they start."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    body()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def in_yardsticks(body, num_runs=5):
    """CPU time of `body` as a multiple of that of the yardstick. The two take turns, so that both meet the same
    machine, and the shortest run of each counts."""
    times_s = [(cpu_time_s(body), cpu_time_s(lambda: subprocess.run(YARDSTICK, check=True))) for _ in range(num_runs)]
    return min(body_s for body_s, _ in times_s) / min(yardstick_s for _, yardstick_s in times_s)
