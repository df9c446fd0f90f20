# SPDX-License-Identifier: Apache-2.0
"""Marks tests that take too long for every change: `make test-nightly` runs them, with NIGHTMAP_NIGHTLY=1."""
import os
import unittest

IS_NIGHT = os.environ.get("NIGHTMAP_NIGHTLY") == "1"
nightly = unittest.skipUnless(IS_NIGHT, "takes minutes: set NIGHTMAP_NIGHTLY=1")


def some_of(items, one_in):
    """All at night, else one in so many: where each takes seconds, and what is tested is the same for all."""
    return list(items)[:: 1 if IS_NIGHT else one_in]
