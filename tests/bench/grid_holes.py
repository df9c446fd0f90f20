# SPDX-License-Identifier: Apache-2.0
"""The narrow unseen holes of a grid, which plan and drive take for free: found by other means than theirs."""

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion, label

ALL_AROUND = np.ones((3, 3))


def holes(free, occupied, max_width):
    """Mask of the parts of unknown cells that touch only free cells and in which no square wider than max_width cells fits. free,
    occupied: masks of the grid's cells; beyond them all is unknown."""
    unknown = np.pad(~(free | occupied), 1, constant_values=True)
    labels, _ = label(unknown, ALL_AROUND)
    wide = binary_erosion(unknown, np.ones((max_width + 1, max_width + 1)), border_value=1)
    no_holes = {labels[0, 0], *labels[wide], *labels[binary_dilation(np.pad(occupied, 1), ALL_AROUND)]}
    return (unknown & ~np.isin(labels, list(no_holes)))[1:-1, 1:-1]
