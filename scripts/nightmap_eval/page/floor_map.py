# SPDX-License-Identifier: Apache-2.0
"""The plan of a site as one drawing with layers, floor by floor. It is SVG in metres, x to the right and y down: y of the map is -y of the
drawing. It needs no script to be seen; floor_map.js zooms it, switches layers and tells places."""

import io

import numpy as np
from matplotlib import colormaps
from PIL import Image

from nightmap_eval import html
from nightmap_eval.floor_plan import FLOOR_REACH_M, floors_at
from nightmap_eval.grid import FREE, OCCUPIED, UNKNOWN, read_grid
from nightmap_eval.walls_and_doors import read_floors

GRAYS = {UNKNOWN: 200, FREE: 255, OCCUPIED: 32}
STEP_M, MAX_POINTS = 0.02, 4000  # between points of a line; more are left out evenly
MARGIN_M = 0.5


class Layer:
    """Parts of the drawing per floor that are shown and hidden together. colors: the color map of a field, for its legend."""

    def __init__(self, name, is_shown=True, colors=None):
        self.name, self.is_shown, self.colors, self.parts = name, is_shown, colors, {}

    def add(self, floor, part):
        self.parts.setdefault(floor, []).append(part)


def cells_png(cells):
    """A pixel per cell, the top row first."""
    picture = Image.fromarray(cells[::-1].copy(), "P")
    picture.putpalette([GRAYS[state] for state in sorted(GRAYS) for _ in range(3)])
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True, bits=2)
    return buffer.getvalue()


def field_png(field):
    """A pixel per cell, the top row first; cells without a value are clear."""
    values = np.ma.masked_invalid(field.values[::-1])
    span = max(field.most - field.least, 1e-9)
    picture = (255 * colormaps[field.colors](np.clip((values - field.least) / span, 0, 1), alpha=0.8)).astype(np.uint8)
    picture[values.mask] = 0
    buffer = io.BytesIO()
    Image.fromarray(picture, "RGBA").save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def raster(picture, size_m, origin_m, yaw_rad=0.0, media_type="image/png"):
    """A picture of a width and height, whose lower left corner lies at origin_m (x, y) of the map, turned about it."""
    (width_m, height_m), (x, y) = size_m, origin_m
    turn = f' transform="rotate({-np.degrees(yaw_rad):.6f} {x:.4f} {-y:.4f})"' if yaw_rad else ""
    return (f'<image x="{x:.4f}" y="{-y - height_m:.4f}" width="{width_m:.4f}" height="{height_m:.4f}" preserveAspectRatio="none" '
            f'href="{html.data_uri(picture, media_type)}"{turn}/>')  # fmt: skip


def points_text(points_m):
    return " ".join(f"{x:.2f},{-y:.2f}" for x, y in np.asarray(points_m)[:, :2] + 0.0)


def size_of(cells, resolution_m):
    rows, columns = cells.shape
    return columns * resolution_m, rows * resolution_m


def polyline(points_m, css_class):
    return f'<polyline class="{css_class}" points="{points_text(points_m)}"/>'


def area(rings_m, css_class, title=""):
    """An outer ring of corners and those of its holes."""
    outline = " ".join("M" + " L".join(points_text(ring_m).split()) + "Z" for ring_m in rings_m)
    return f'<path class="{css_class}" fill-rule="evenodd" d="{outline}">{_title(title)}</path>'


def label(x, y, text):
    return f'<text x="{x:.2f}" y="{-y:.2f}">{html.escape(text)}</text>'


def circle(x, y, title, css_class=""):
    return f'<circle class="{css_class}" cx="{x:.2f}" cy="{-y:.2f}">{_title(title)}</circle>'


def _title(text):
    return f"<title>{html.escape(text)}</title>" if text else ""


def thinned(points_m):
    """Points of a line that are at least STEP_M apart, MAX_POINTS at most."""
    kept = [0]
    for i in range(1, len(points_m)):
        if np.hypot(*(points_m[i][:2] - points_m[kept[-1]][:2])) >= STEP_M:
            kept.append(i)
    kept += [len(points_m) - 1] if kept[-1] != len(points_m) - 1 else []
    step = -(-len(kept) // MAX_POINTS)
    return points_m[kept[::step]]


class Plan:
    """The floors of a site: their grids where it has a grid, and on which of them a point is."""

    def __init__(self, site):
        has_grid = site.made("grid", "yaml") is not None
        self.floors = read_floors(site) if has_grid else [{"number": 0, "height_m": 0.0}]
        self.grids = {floor["number"]: read_grid(site.folder_of("grid") / floor["yaml"]) for floor in self.floors} if has_grid else {}
        self._reach_m = {floor["number"]: [] for floor in self.floors}
        for number, grid in self.grids.items():
            rows, columns = np.nonzero(grid.cells != UNKNOWN)
            if len(rows):
                self.reach(number, grid.from_cells(*np.meshgrid([columns.min(), columns.max() + 1], [rows.min(), rows.max() + 1])).reshape(-1, 2))

    def reach(self, floor, points_m):
        """Lets the view of a floor hold these points."""
        if len(points_m):
            points_m = np.asarray(points_m)[:, :2]
            self._reach_m[floor] += [points_m.min(axis=0), points_m.max(axis=0)]

    def bounds_m(self, floor):
        """Lower and upper corner of what the floor holds."""
        points_m = np.array(self._reach_m[floor]) if self._reach_m[floor] else np.array([[0.0, 0.0], [1, 1]])
        return points_m.min(axis=0), points_m.max(axis=0)

    def view(self, floor):
        """x, y, width, height of the drawing."""
        low, high = self.bounds_m(floor)
        low, high = low - MARGIN_M, high + MARGIN_M
        return " ".join(f"{value:.3f}" for value in (low[0], -high[1], *(high - low)))

    def numbers_at(self, heights_m, reach_m=FLOOR_REACH_M):
        """Number of the floor below each height."""
        by_height, indices = floors_at(self.floors, heights_m, reach_m)
        return np.array([floor["number"] for floor in by_height])[indices]

    def add_way(self, layer, positions_m, css_class):
        """Adds a line of positions (n, 3), in pieces by floor."""
        if len(positions_m) == 0:
            return
        numbers = self.numbers_at(positions_m[:, 2])
        cuts = np.nonzero(np.diff(numbers))[0] + 1
        for piece in np.split(np.arange(len(numbers)), cuts):
            number = int(numbers[piece[0]])
            layer.add(number, polyline(thinned(positions_m[piece]), css_class))
            self.reach(number, positions_m[piece])


def drawing(name, plan, layers, command):
    """The plan with its bar of layers and floors. command: of make, to which a click gives START and GOAL; empty without one."""
    layers = [layer for layer in layers if layer.parts]
    boxes = "".join(f'<label><input type="checkbox" value="{html.escape(layer.name)}"{" checked" if layer.is_shown else ""}> '
                    f"{html.escape(layer.name)}{_ramp(layer)}</label>" for layer in layers)  # fmt: skip
    groups = "".join(
        f'<g data-layer="{html.escape(layer.name)}" data-floor="{floor}"{_hidden(layer, floor)}>{"".join(parts)}</g>'
        for layer in layers for floor, parts in sorted(layer.parts.items()))  # fmt: skip
    views = "".join(f'<g data-view-of="{floor["number"]}" data-view="{plan.view(floor["number"])}"/>' for floor in plan.floors)
    options = "".join(f'<option value="{floor["number"]}"{" selected" if floor["number"] == 0 else ""}>floor {floor["number"]} at '
                      f'{floor["height_m"]:.1f} m</option>' for floor in plan.floors)  # fmt: skip
    chooser = f'<label>floor <select>{options}</select></label>' if len(plan.floors) > 1 else ""
    zoom = ('<span class="zoom"><button type="button" data-zoom="in" aria-label="zoom in">+</button> '
            '<button type="button" data-zoom="out" aria-label="zoom out">−</button> '
            '<button type="button" data-zoom="fit">whole plan</button></span>')  # fmt: skip
    about = f"Plan of {name}: arrow keys move, + and - zoom, Enter takes the middle's coordinates"
    return html.Raw(
        f'<div class="floor-map" id="plan" data-floor="0" data-command="{html.escape(command)}"><div class="bar">{zoom}{chooser}</div>'
        f'<details class="layers"><summary>layers</summary><div class="bar">{boxes}</div></details>'
        f'<svg viewBox="{plan.view(0)}" tabindex="0" role="application" aria-label="{html.escape(about)}">{groups}{views}'
        '<path class="origin" d="M-0.2,0H0.2M0,-0.2V0.2"><title>x = 0, y = 0</title></path><g class="picked"/></svg>'
        '<p class="scale" aria-hidden="true"><span></span> <output></output></p>'
        f'<p class="readout" aria-live="polite"></p></div>{html.script("floor_map.js")}')  # fmt: skip


def _ramp(layer):
    """Colors of a field, from its least to its largest value."""
    if layer.colors is None:
        return ""
    steps = ", ".join("#" + "".join(f"{round(255 * part):02x}" for part in colormaps[layer.colors](share)[:3]) for share in np.linspace(0, 1, 6))
    return f' <span class="ramp" style="background: linear-gradient(to right, {steps})"></span>'


def _hidden(layer, floor):
    return "" if layer.is_shown and floor == 0 else ' style="display:none"'
