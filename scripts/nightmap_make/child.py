# SPDX-License-Identifier: Apache-2.0
"""The program that runs at present; a signal to this one ends it, and no other is started."""

import os
import signal

PASSED_ON = (signal.SIGTERM, signal.SIGHUP)


class Child:
    def __init__(self):
        self._pid = self._ended_by = None

    def pass_signals_on(self):
        for number in PASSED_ON:
            signal.signal(number, self._pass_on)

    def run(self, command, environment, **more):
        """Returns the exit code of a command, or its signal's number below 256. more: of os.posix_spawnp."""
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)  # none comes between the look at it and the start
        try:
            if self._ended_by:
                return -self._ended_by & 0xff
            pid = self._pid = os.posix_spawnp(command[0], command, environment, setsigmask=blocked, **more)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        while True:
            try:
                os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)  # its number stays its own until waitpid
                self._pid = None
                return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) & 0xff
            except KeyboardInterrupt:  # the program got the signal too, and ends what it started
                continue

    def _pass_on(self, number, _):
        self._ended_by = number
        if self._pid:
            os.kill(self._pid, number)
