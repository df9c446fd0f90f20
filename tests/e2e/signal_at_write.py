# SPDX-License-Identifier: Apache-2.0
"""Runs that a signal reaches at a certain moment, however busy the machine is: while they write a certain file."""
import os
import pathlib
import signal
import subprocess
import tempfile

from workspace import environment

SOURCE = pathlib.Path(__file__).with_suffix(".cc")


class SignalAtWrite:
    """A library that is loaded into the programs of a run."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="nightmap-e2e-")
        self.library = pathlib.Path(self.folder.name) / "signal_at_write.so"
        compiler = os.environ.get("CXX", "c++")
        subprocess.run([compiler, "-std=c++20", "-shared", "-fPIC", "-o", self.library, SOURCE, "-ldl"], check=True)

    def remove(self):
        self.folder.cleanup()

    def environment(self, path, number):
        """For a run that gets the signal when half of its first write to a file whose path contains `path` is done."""
        return environment() | {"LD_PRELOAD": str(self.library), "SIGNAL_AT_PATH": path, "SIGNAL_AT_WRITE": str(int(number))}

    def kill(self, command, folder, path):
        """Runs a command that is killed, with all it started, when it writes such a file."""
        run = subprocess.run(command, cwd=folder, env=self.environment(path, signal.SIGKILL), start_new_session=True, text=True,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip
        if run.returncode != -signal.SIGKILL:
            raise AssertionError(f"nothing wrote {path}: exit code {run.returncode}\n{run.stdout}")
