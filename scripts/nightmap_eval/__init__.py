# SPDX-License-Identifier: Apache-2.0
"""What evaluate.py and report.py share: readers of artifacts and the accuracy metrics."""
