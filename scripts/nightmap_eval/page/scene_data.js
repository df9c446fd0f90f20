// SPDX-License-Identifier: Apache-2.0
// Reads the data of the view out of the page: packed clouds (scene_cloud.py) and other bytes, as zlib and base64.
"use strict";

const PARTS = 65535, NO_FACING = 255;

// The bytes of a script of the page.
async function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Blocks of a packed cloud: corner (m), places (3 uint16 per point), tints (3 bytes per point), facings (a byte per point).
// palette: [red, green, blue] of each class, of a cloud that has classes instead of colors.
function blocksOf(bytes, head, palette) {
  const count = head.num_points, places = new Uint16Array(3 * count), tints = new Uint8Array(3 * count);
  const numbers = new Uint16Array(bytes.buffer, bytes.byteOffset, 3 * count);
  const column = name => bytes.subarray((6 + head.columns.indexOf(name)) * count, (7 + head.columns.indexOf(name)) * count);
  for (let axis = 0; axis < 3; ++axis)
    for (let i = 0; i < count; ++i) places[3 * i + axis] = numbers[axis * count + i];
  const colors = palette ? [] : ["red", "green", "blue"].map(column), classes = palette && column("label");
  for (let i = 0; i < count; ++i)
    for (let k = 0; k < 3; ++k) tints[3 * i + k] = palette ? (palette[classes[i]] || UNCLASSED)[k] : colors[k][i];
  const facings = column("facing"), blocks = [];
  let first = 0;
  for (const [x, y, z, size] of head.blocks) {
    const end = first + size;
    blocks.push({corner: [x, y, z].map(part => part * head.block_m), count: size, places: places.subarray(3 * first, 3 * end),
                 tints: tints.subarray(3 * first, 3 * end), facings: facings.subarray(first, end)});
    first = end;
  }
  return blocks;
}

const UNCLASSED = [150, 150, 150];

const vectors = numbers => Array.from({length: numbers.length / 3}, (_, i) => new THREE.Vector3().fromArray(numbers, 3 * i));

function rgbOf(hex) {
  return [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));
}

// The direction that a facing stands for (facings of scene_cloud.py).
function normalOf(facing) {
  const up = (Math.floor(facing / 36) - 3) * Math.PI / 6, around = (facing % 36) * Math.PI / 18;
  return [Math.cos(up) * Math.cos(around), Math.cos(up) * Math.sin(around), Math.sin(up)];
}
