# SPDX-License-Identifier: Apache-2.0
"""Runs the declared pipeline with make: declaration, rules of a site, check before a run, summary after it."""
