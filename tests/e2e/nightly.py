# SPDX-License-Identifier: Apache-2.0
"""Marks tests that take too long for every change: `make test-nightly` runs them, with NIGHTMAP_NIGHTLY=1."""
import os
import unittest

nightly = unittest.skipUnless(os.environ.get("NIGHTMAP_NIGHTLY") == "1", "takes minutes: set NIGHTMAP_NIGHTLY=1")
