# SPDX-License-Identifier: Apache-2.0
"""Runs the declared pipeline with make: declaration, rules of a site, check before a run, summary after it."""

import nightmap_eval  # noqa: F401  (its compiled modules are written whole, and so are those of this package)
