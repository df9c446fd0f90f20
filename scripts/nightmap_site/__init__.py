# SPDX-License-Identifier: Apache-2.0
"""A site for all scripts: its declared pipeline, where its files are, lists, receipts and reports. Knows neither nightmap_make
nor nightmap_eval, imports little, and keeps the compiled modules of every package whole."""

import contextlib
import importlib.machinery
import os


def write_module(_loader, path, data, *, _mode=0o666):
    """Python before 3.14 leaves half a .pyc where the disk gets full, and each later import ends in EOFError.
    (This file's own is smaller than a block: whole or none.)"""
    temporary = f"{path}.{os.getpid()}"
    with contextlib.suppress(OSError):  # a module that is not kept is compiled again
        os.makedirs(os.path.dirname(path), exist_ok=True)
        try:
            with open(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _mode & 0o666), "wb") as file:
                file.write(data)
            os.replace(temporary, path)
        except OSError:
            os.unlink(temporary)


importlib.machinery.SourceFileLoader.set_data = write_module
