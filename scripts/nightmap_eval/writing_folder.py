# SPDX-License-Identifier: Apache-2.0
"""A folder for the files of one run until they are complete; like pipeline/base/writing_folder.h."""

import fcntl
import os
import shutil
import tempfile
from pathlib import Path


def _lock(path, how):
    """A descriptor that holds the lock of a folder; None when the folder is gone or another process holds the lock."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, how)
        return descriptor
    except OSError:
        os.close(descriptor)
        return None


def _remove_left_behind(parent, prefix):
    for path in parent.glob(f"{prefix}*"):
        if "." in path.name.removeprefix(prefix):
            continue  # it belongs to a host with a longer name
        descriptor = _lock(path, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if descriptor is not None:
            shutil.rmtree(path, ignore_errors=True)
            os.close(descriptor)


class WritingFolder:
    """`.writing.<host>.<random>` in a folder, removed with its content at the end of `with`.

    The next run of a script or stage on this host removes the folder of a killed run, whose lock is free."""

    def __init__(self, parent):
        prefix = f".writing.{os.uname().nodename}."
        _remove_left_behind(Path(parent), prefix)
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
            self._descriptor = _lock(self.path, fcntl.LOCK_EX)
            if self.path.exists():  # otherwise another run removed it before the lock was held
                break

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def __enter__(self):
        return self.path

    def __exit__(self, *_):
        self.remove()
