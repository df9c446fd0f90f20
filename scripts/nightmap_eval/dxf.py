# SPDX-License-Identifier: Apache-2.0
"""Features of a floor plan as a drawing: DXF of AutoCAD 2000 (AC1015), ASCII, in metres. Every CAD program reads this version, and it is
the first that states units. The groups are those of the DXF Reference (Autodesk)."""

from itertools import chain

import numpy as np

from nightmap_eval.polygons import Polygon

LAYERS = {"wall": "WALLS", "room": "ROOMS", "trajectory": "TRAJECTORY", "path": "PATH", "thing": "THINGS"}
TEXTS = {"room": "ROOM_TEXT", "thing": "THING_TEXT"}
COLOURS = {"WALLS": 7, "ROOMS": 3, "ROOM_TEXT": 3, "TRAJECTORY": 8, "PATH": 1, "THINGS": 5, "THING_TEXT": 5}
TEXT_HEIGHT_M = 0.2
METRES, METRIC = 6, 1
# Fixed handles: of tables, of the two spaces that every drawing has, of the dictionaries of objects.
TABLES = {name: f"{number:X}" for number, name in enumerate(
    ("VPORT", "LTYPE", "LAYER", "STYLE", "VIEW", "UCS", "APPID", "DIMSTYLE", "BLOCK_RECORD"), 1)}  # fmt: skip
MODEL_SPACE, PAPER_SPACE, ROOT, GROUPS, FIRST_FREE = "20", "21", "30", "31", 0x40


class Drawing:
    """Groups (code, value) of a file, with handles in order."""

    def __init__(self):
        self.groups, self._next = [], FIRST_FREE

    def add(self, *values):
        """Codes and values in turn."""
        self.groups += zip(values[::2], values[1::2])

    def handle(self):
        self._next += 1
        return f"{self._next - 1:X}"

    def text(self):
        return "".join(f"{code:>3}\n{_shown(value)}\n" for code, value in self.groups)


def _shown(value):
    """A value as DXF writes it: floats with a point; text in ASCII, other letters as \\U+XXXX, in one line."""
    if isinstance(value, (float, np.floating)):
        return f"{round(float(value), 4) + 0.0:.4f}"
    units = memoryview(str(value).encode("utf-16-be", "replace"))
    codes = [units[i] << 8 | units[i + 1] for i in range(0, len(units), 2)]
    return "".join(chr(code) if 32 <= code < 127 else " " if code < 32 or code == 127 else f"\\U+{code:04X}" for code in codes)


def dxf_text(features):
    """The file's text. Layers are KIND_FLOOR, like WALLS_0; polylines lie at the height of their floor; those of areas are closed."""
    layers = list(dict.fromkeys(chain.from_iterable(_layers(feature) for feature in features)))
    body = Drawing()
    body.add(0, "SECTION", 2, "ENTITIES")
    for feature in features:
        _add_feature(body, feature)
    body.add(0, "ENDSEC")
    head = Drawing()
    head._next = body._next
    _add_tables(head, layers)
    _add_blocks(head)
    last = Drawing()
    last.add(0, "SECTION", 2, "OBJECTS", 0, "DICTIONARY", 5, ROOT, 330, "0", 100, "AcDbDictionary", 281, 1, 3, "ACAD_GROUP", 350, GROUPS)
    last.add(0, "DICTIONARY", 5, GROUPS, 330, ROOT, 100, "AcDbDictionary", 281, 1, 0, "ENDSEC", 0, "EOF")
    return "".join(part.text() for part in (_header(features, head.handle()), head, body, last))


def _layers(feature):
    yield f"{LAYERS[feature.kind]}_{feature.floor}"
    if feature.label:
        yield f"{TEXTS[feature.kind]}_{feature.floor}"


def _header(features, next_handle):
    points = [_rings(feature.shape)[0] for feature in features] or [np.zeros((1, 2))]
    low, high = np.min([ring.min(axis=0) for ring in points], axis=0), np.max([ring.max(axis=0) for ring in points], axis=0)
    heights = [float(feature.height_m) for feature in features] or [0.0]
    header = Drawing()
    header.add(0, "SECTION", 2, "HEADER", 9, "$ACADVER", 1, "AC1015", 9, "$DWGCODEPAGE", 3, "ANSI_1252", 9, "$HANDSEED", 5, next_handle)
    header.add(9, "$INSUNITS", 70, METRES, 9, "$MEASUREMENT", 70, METRIC)
    header.add(9, "$EXTMIN", 10, low[0], 20, low[1], 30, min(heights), 9, "$EXTMAX", 10, high[0], 20, high[1], 30, max(heights))
    header.add(0, "ENDSEC", 0, "SECTION", 2, "CLASSES", 0, "ENDSEC")
    return header


def _add_tables(drawing, layers):
    records = {
        "LTYPE": [("AcDbLinetypeTableRecord", 2, name, 70, 0, 3, "", 72, 65, 73, 0, 40, 0.0) for name in ("ByBlock", "ByLayer", "Continuous")],
        "LAYER": [("AcDbLayerTableRecord", 2, name, 70, 0, 62, COLOURS.get(name.rpartition("_")[0], 7), 6, "Continuous") for name in ("0", *layers)],
        "STYLE": [("AcDbTextStyleTableRecord", 2, "Standard", 70, 0, 40, 0.0, 41, 1.0, 50, 0.0, 71, 0, 42, TEXT_HEIGHT_M, 3, "txt", 4, "")],
        "APPID": [("AcDbRegAppTableRecord", 2, "ACAD", 70, 0)],
        "BLOCK_RECORD": [("AcDbBlockTableRecord", 2, "*Model_Space"), ("AcDbBlockTableRecord", 2, "*Paper_Space")],
    }
    drawing.add(0, "SECTION", 2, "TABLES")
    for table, handle in TABLES.items():
        entries = records.get(table, [])
        drawing.add(0, "TABLE", 2, table, 5, handle, 330, "0", 100, "AcDbSymbolTable", 70, len(entries))
        if table == "DIMSTYLE":
            drawing.add(100, "AcDbDimStyleTable", 71, 0)
        for number, (kind, *groups) in enumerate(entries):
            own = (MODEL_SPACE, PAPER_SPACE)[number] if table == "BLOCK_RECORD" else drawing.handle()
            drawing.add(0, table, 5, own, 330, handle, 100, "AcDbSymbolTableRecord", 100, kind, *groups)
        drawing.add(0, "ENDTAB")
    drawing.add(0, "ENDSEC")


def _add_blocks(drawing):
    drawing.add(0, "SECTION", 2, "BLOCKS")
    for name, space in (("*Model_Space", MODEL_SPACE), ("*Paper_Space", PAPER_SPACE)):
        drawing.add(0, "BLOCK", 5, drawing.handle(), 330, space, 100, "AcDbEntity", 8, "0", 100, "AcDbBlockBegin")
        drawing.add(2, name, 70, 0, 10, 0.0, 20, 0.0, 30, 0.0, 3, name, 1, "")
        drawing.add(0, "ENDBLK", 5, drawing.handle(), 330, space, 100, "AcDbEntity", 8, "0", 100, "AcDbBlockEnd")
    drawing.add(0, "ENDSEC")


def _rings(shape):
    return [shape.outer, *shape.holes] if isinstance(shape, Polygon) else [shape]


def _add_feature(drawing, feature):
    layer, *text_layer = _layers(feature)
    height_m = float(feature.height_m)
    for ring in _rings(feature.shape):
        drawing.add(0, "LWPOLYLINE", 5, drawing.handle(), 330, MODEL_SPACE, 100, "AcDbEntity", 8, layer, 100, "AcDbPolyline")
        drawing.add(90, len(ring), 70, int(isinstance(feature.shape, Polygon)), 38, height_m)
        for x, y in ring:
            drawing.add(10, x, 20, y)
    for name in text_layer:
        x, y = map(float, feature.label_m)
        drawing.add(0, "TEXT", 5, drawing.handle(), 330, MODEL_SPACE, 100, "AcDbEntity", 8, name, 100, "AcDbText")
        drawing.add(10, x, 20, y, 30, height_m, 40, TEXT_HEIGHT_M, 1, feature.label, 72, 1, 11, x, 21, y, 31, height_m, 100, "AcDbText", 73, 2)
