# SPDX-License-Identifier: Apache-2.0
"""Evaluation and report: readers of artifacts, accuracy, comparison with COLMAP, pictures, HTML."""

import nightmap_site  # noqa: F401  (keeps compiled modules whole)
