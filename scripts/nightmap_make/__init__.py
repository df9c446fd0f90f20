# SPDX-License-Identifier: Apache-2.0
"""Runs the declared pipeline with make: rules of a site, check before a run, summary after it."""

import nightmap_site  # noqa: F401  (keeps compiled modules whole)
