# SPDX-License-Identifier: Apache-2.0
"""Files and folders below a folder that are opened while a test's body runs, by inotify."""
import ctypes
import os
import struct

IN_OPEN = 0x20
EVENT = struct.Struct("iIII")  # watch, mask, cookie, length of the name that follows
BUFFER_BYTES = 1 << 16


class OpenedFiles:
    """After `with`, `names` holds the paths opened in the meantime, relative to the folder; "." is the folder itself."""

    def __init__(self, folder):
        self.folder, self.names, self._watches = os.fspath(folder), set(), {}

    def __enter__(self):
        libc = ctypes.CDLL(None, use_errno=True)
        folders = [path for path, _, _ in os.walk(self.folder)]
        self._descriptor = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        for path in folders:
            watch = libc.inotify_add_watch(self._descriptor, os.fsencode(path), IN_OPEN)
            if watch < 0:
                raise OSError(ctypes.get_errno(), "inotify_add_watch", path)
            self._watches[watch] = os.path.relpath(path, self.folder)
        return self

    def __exit__(self, *_):
        while True:
            try:
                self._read(os.read(self._descriptor, BUFFER_BYTES))
            except BlockingIOError:
                break
        os.close(self._descriptor)

    def _read(self, events):
        while events:
            watch, _, _, length = EVENT.unpack_from(events)
            name = events[EVENT.size:EVENT.size + length].rstrip(b"\0").decode()
            if watch not in self._watches:
                raise AssertionError("more was opened than inotify's queue holds")
            self.names.add(os.path.normpath(os.path.join(self._watches[watch], name)))
            events = events[EVENT.size + length:]
