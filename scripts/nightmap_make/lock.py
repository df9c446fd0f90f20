# SPDX-License-Identifier: Apache-2.0
"""Allows one make at a time per site. The kernel frees the lock when its process dies, for whatever reason."""

import contextlib
import fcntl
import os
import sys
import time

from nightmap_site.script_errors import DataError


def is_held(site_dir):
    """Whether another process makes the site now."""
    try:
        with open(f"{site_dir}/.lock", "rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass  # nothing was ever made
    return False


class SiteLock:
    """A lock held until the process ends. Waits for the process that holds it, and names that process."""

    def __init__(self, site_dir):
        os.makedirs(site_dir, exist_ok=True)
        self.path = f"{site_dir}/.lock"
        self._fd = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)  # child processes do not inherit it
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.pread(self._fd, 200, 0).decode("utf-8", "replace").strip() or "(unknown)"
            print(f"nightmap: {site_dir} is being made by process {holder}: this make waits for it to end", file=sys.stderr)
            fcntl.flock(self._fd, fcntl.LOCK_EX)
        except OSError as error:
            raise DataError(f"{self.path} cannot be locked ({error.strerror}), so that two makes could write one site: "
                            "let the file system have locks (NFS 4; Lustre: -o flock), or choose another one with MAPS") from None
        os.ftruncate(self._fd, 0)
        with contextlib.suppress(OSError):  # on a full disk it holds without a name
            os.pwrite(self._fd, f"{os.getpid()} on {os.uname().nodename} since {time.strftime('%Y-%m-%d %H:%M:%S')}\n".encode(), 0)

    def release(self):
        os.ftruncate(self._fd, 0)
        os.close(self._fd)
