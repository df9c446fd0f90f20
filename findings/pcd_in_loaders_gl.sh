#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The npm package @loaders.gl/pcd 4.4.2 (core 4.4.5) gives other positions than a PCD file holds, without an error, when
# - the coordinates of a binary file have 8 bytes (SIZE 8, as PCL writes fields of type double): it reads the first 4 of them as floats;
# - a field before x of an ASCII file has several values (COUNT 2, as descriptors have): it counts fields, not values.
# The same COUNT in a binary file is read right. Both files are valid by the PCD 0.7 specification. Expected are 1.5, 2.5, 3.5.
# Seen with Node 20. A viewer of point clouds built on the package shows a cloud that is not in the file.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund @loaders.gl/core@4.4.5 @loaders.gl/pcd@4.4.2
cat >read.mjs <<'JS'
import { parse } from '@loaders.gl/core';
import { PCDLoader } from '@loaders.gl/pcd';

const header = (fields, size, count, data) => {
  const type = fields.replace(/\S+/g, 'F');
  return `VERSION 0.7\nFIELDS ${fields}\nSIZE ${size}\nTYPE ${type}\nCOUNT ${count}\nWIDTH 1\nHEIGHT 1\n` +
         `VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ${data}\n`;
};
const read = async (name, text, body = new Uint8Array()) => {
  const bytes = new Uint8Array([...new TextEncoder().encode(text), ...body]);
  const cloud = await parse(bytes.buffer, PCDLoader, { worker: false });
  console.log(name, [...cloud.attributes.POSITION.value].join(' '));
};
const doubles = new Uint8Array(new Float64Array([1.5, 2.5, 3.5]).buffer);
const floats = new Uint8Array(new Float32Array([9, 8, 1.5, 2.5, 3.5]).buffer);
await read('binary SIZE 8:', header('x y z', '8 8 8', '1 1 1', 'binary'), doubles);
await read('ascii COUNT 2:', header('pair x y z', '4 4 4 4', '2 1 1 1', 'ascii') + '9 8 1.5 2.5 3.5\n');
await read('binary COUNT 2:', header('pair x y z', '4 4 4 4', '2 1 1 1', 'binary'), floats);
JS
node read.mjs | tee seen
diff seen - <<'SEEN'
binary SIZE 8: 0 0 0
ascii COUNT 2: 8 1.5 2.5
binary COUNT 2: 1.5 2.5 3.5
SEEN
