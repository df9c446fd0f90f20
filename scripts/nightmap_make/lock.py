# SPDX-License-Identifier: Apache-2.0
"""One make at a time per site. The kernel ends the lock with the process that holds it, however that dies."""

import fcntl
import os
import sys
import time


class SiteLock:
    """Held until the process ends. Waits for the one that holds it, and says which that is."""

    def __init__(self, site_dir):
        os.makedirs(site_dir, exist_ok=True)
        self.path = f"{site_dir}/.lock"
        self._fd = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)  # not inherited by what is started
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print(f"nightmap: {site_dir} is being made by process {self._holder()}: this make waits for it to end", file=sys.stderr)
            fcntl.flock(self._fd, fcntl.LOCK_EX)
        os.ftruncate(self._fd, 0)
        os.pwrite(self._fd, f"{os.getpid()} on {os.uname().nodename} since {time.strftime('%Y-%m-%d %H:%M:%S')}\n".encode(), 0)

    def _holder(self):
        return os.pread(self._fd, 200, 0).decode("utf-8", "replace").strip() or "(unknown)"

    def release(self):
        os.ftruncate(self._fd, 0)
        os.close(self._fd)
