# SPDX-License-Identifier: Apache-2.0
"""Pictures of grids: a map of another system may be turned by the yaw of its origin."""
import unittest

import numpy as np

import fake_site  # noqa: F401  (it makes scripts/ importable)
from nightmap_eval import drawing
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, Grid


class DrawGridTest(unittest.TestCase):
    def drawn(self, yaw_rad):
        """The shade of the picture at the centre of each cell."""
        cells = np.full((12, 30), FREE, dtype=np.uint8)
        cells[:, 20:] = OCCUPIED
        cells[:4, :10] = UNKNOWN
        grid = Grid(cells, 0.1, 5.0, -3.0, yaw_rad)
        figure, axes = drawing.map_axes("")
        axes.set_aspect("equal", adjustable="box")
        drawing.draw_grid(axes, grid)
        figure.canvas.draw()
        picture = np.asarray(figure.canvas.buffer_rgba())[::-1, :, 0]
        columns, rows = np.floor(axes.transData.transform(grid.centres_m().reshape(-1, 2))).astype(int).T
        drawing.plt.close(figure)
        return cells, picture[rows, columns].reshape(cells.shape)

    def test_every_cell_is_where_its_centre_is(self):
        for yaw_rad in (0.0, 0.5, -2.5):
            with self.subTest(yaw_rad=yaw_rad):
                cells, shades = self.drawn(yaw_rad)
                for state, shade in ((FREE, 0xFF), (OCCUPIED, 0x20), (UNKNOWN, 0xC8)):
                    right = np.mean(np.abs(shades[cells == state].astype(int) - shade) < 4)
                    self.assertGreater(right, 0.95)
