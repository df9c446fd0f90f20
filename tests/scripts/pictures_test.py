# SPDX-License-Identifier: Apache-2.0
"""Pictures that the scripts open: label pictures as stored, and no files of other kinds."""
import os
import struct
import zlib

import numpy as np
from PIL import Image

from folder_case import FolderTest
from nightmap_eval.pictures import open_picture, read_labels


GRAY, PALETTE = 0, 3


def png(num_bits, color):
    """16 x 8 values 0, 1, 2 ..., as many as the bits hold; the colors of the palette are others."""
    values = (np.arange(16 * 8) % (1 << num_bits)).astype(np.uint8).reshape(8, 16)
    bits = np.unpackbits(values[..., None], axis=2)[..., 8 - num_bits:]
    rows = b"".join(b"\0" + row.tobytes() for row in np.packbits(bits.reshape(8, -1), axis=1))
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", 16, 8, num_bits, color, 0, 0, 0))]
    if color == PALETTE:
        chunks.append((b"PLTE", bytes((255, 128, 64)) * (1 << num_bits)))
    chunks += [(b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return values, b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in chunks)


class PicturesTest(FolderTest):
    def setUp(self):
        self.path = self.folder / "a.png"

    def test_labels_are_the_values_as_stored(self):
        for color in (GRAY, PALETTE):
            for num_bits in (1, 2, 4, 8):
                values, written = png(num_bits, color)
                self.path.write_bytes(written)
                with self.subTest(color=color, num_bits=num_bits):
                    self.assertEqual(read_labels(self.path).tolist(), values.tolist())

    def test_pictures_of_the_stages_are_opened(self):
        for name in ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP"):
            Image.new("RGB", (8, 6), (9, 9, 9)).save(self.path, name)
            with self.subTest(name), open_picture(self.path) as picture:
                self.assertEqual(picture.convert("RGB").size, (8, 6))

    def test_files_of_other_kinds_are_not(self):
        for name in ("GIF", "EPS", "TGA", "PCX"):
            Image.new("RGB", (8, 6)).save(self.path, name)
            with self.subTest(name), self.assertRaises(OSError):
                open_picture(self.path)
        self.path.unlink()
        os.mkfifo(self.path)
        with self.assertRaises(OSError):
            open_picture(self.path)
