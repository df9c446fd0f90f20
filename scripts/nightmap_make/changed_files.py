# SPDX-License-Identifier: Apache-2.0
"""Files that Make compares by time: they are written whole, and only when they changed."""

import contextlib
import glob
import os
import time

from nightmap_site.script_errors import writing

LEFT_BEHIND_S = 3600  # an older temporary file belongs to no running process
try:  # hashlib loads OpenSSL: a twelfth of the time of a make that finds nothing to do
    from _sha256 import sha256
except ImportError:  # another Python than 3.11
    from hashlib import sha256


def has_text(path, text):
    """Whether a file of an earlier call holds this text; a damaged file does not."""
    if not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read() == text.encode("utf-8", "surrogatepass")


def write(path, text, mtime_ns=None):
    """Writes a temporary file of this run, then renames it. Removes old temporary files, which killed runs left."""
    for left in glob.glob(f"{glob.escape(path)}.*.tmp"):
        with contextlib.suppress(OSError):
            if time.time() - os.stat(left).st_mtime > LEFT_BEHIND_S:
                os.remove(left)
    temporary = f"{path}.{os.getpid()}-{os.urandom(6).hex()}.tmp"
    try:
        with writing(path):
            with open(temporary, "x", encoding="utf-8") as file:
                file.write(text)
            if mtime_ns is not None:
                os.utime(temporary, ns=(mtime_ns, mtime_ns))
            os.replace(temporary, path)
    finally:
        with contextlib.suppress(FileNotFoundError):  # it has its final name
            os.remove(temporary)


def write_if_changed(path, text):
    if not has_text(path, text):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        write(path, text)


def settle(current, target, text, means_same=lambda path: False, changed_ns=lambda: None):
    """Writes `target`, which is `current` or its preview, unless it is current and holds the text. It gets the time of
    `current` where that means the same, else changed_ns(); None: the present."""
    has_same_text = has_text(current, text)
    if has_same_text and current == target:
        return
    keeps_time = has_same_text or means_same(current)
    os.makedirs(os.path.dirname(target), exist_ok=True)
    write(target, text, os.stat(current).st_mtime_ns if keeps_time else changed_ns())


def digest(text):
    """64 hexadecimal digits; surrogates stand for bytes of names that are no UTF-8."""
    return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()
