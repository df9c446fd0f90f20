# SPDX-License-Identifier: Apache-2.0
"""Shared code of evaluate.py and report.py: readers of artifacts and the accuracy metrics."""
