#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# PCDLoader of the npm package three 0.187.0 gives the field `label` of a PCD file as signed integers, whatever its TYPE: a label of
# 3000000000 in a field of TYPE U and SIZE 4, as PCL's PointXYZL has it, becomes -1294967296, in ASCII and binary files, and nothing
# warns. PLYLoader of the same package gives the same value of a `property uint` as it is.
# Seen with Node 20. Labels that pack an instance into their upper bits, as those of SemanticKITTI, turn negative from instance 32768 on.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund three@0.187.0
cat >read.mjs <<'JS'
import { PCDLoader } from 'three/examples/jsm/loaders/PCDLoader.js';
import { PLYLoader } from 'three/examples/jsm/loaders/PLYLoader.js';

const LABEL = 3000000000;
const header = (data) => 'VERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 1\nHEIGHT 1\n' +
                         `VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ${data}\n`;
const label_of = (text, body = new Uint8Array()) => {
  const bytes = new Uint8Array([...new TextEncoder().encode(text), ...body]);
  return new PCDLoader().parse(bytes.buffer).geometry.attributes.label.array[0];
};
const body = new DataView(new ArrayBuffer(16));
[1, 2, 3].forEach((value, i) => body.setFloat32(4 * i, value, true));
body.setUint32(12, LABEL, true);
console.log('PCD ascii:', label_of(header('ascii') + `1 2 3 ${LABEL}\n`));
console.log('PCD binary:', label_of(header('binary'), new Uint8Array(body.buffer)));
const ply = new PLYLoader();
ply.setCustomPropertyNameMapping({ label: ['label'] });
const mesh = ply.parse('ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n' +
                       `property uint label\nend_header\n1 2 3 ${LABEL}\n`);
console.log('PLY ascii:', mesh.attributes.label.array[0]);
JS
node read.mjs | tee seen
diff seen - <<'SEEN'
PCD ascii: -1294967296
PCD binary: -1294967296
PLY ascii: 3000000000
SEEN
