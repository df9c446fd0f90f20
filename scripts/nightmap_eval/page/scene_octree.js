// SPDX-License-Identifier: Apache-2.0
// The occupied leaves of an octree as cubes in the color of their height. Reads OctoMap's binary format (.bt): two bits per child of a
// node, in the order of the tree; 1 is a free leaf, 2 an occupied one, 3 a node that follows.
"use strict";

const TREE_DEPTH = 16, MAX_CUBES = 300000, MAX_HEADER = 4096;
const FREE_LEAF = 1, OCCUPIED_LEAF = 2, INNER = 3;

function octreeHeader(bytes) {
  const text = new TextDecoder("latin1").decode(bytes.subarray(0, MAX_HEADER)), end = text.indexOf("\ndata\n");
  const resolution = /^res ([-+.\de]+)$/m.exec(text.slice(0, Math.max(0, end))), size = /^size (\d+)$/m.exec(text.slice(0, Math.max(0, end)));
  if (end < 0 || !resolution || !size || !(Number(resolution[1]) > 0)) throw new Error("the octree is damaged");
  return {resolution_m: Number(resolution[1]), isEmpty: Number(size[1]) === 0, start: end + "\ndata\n".length};
}

// Calls found(x, y, z, edge) for each occupied leaf, the lower corner and edge in leaves of the deepest level; nodes at maxDepth are
// taken for leaves, occupied if anything in them is.
function occupiedLeaves(bytes, start, maxDepth, found) {
  let at = start;
  const node = (x, y, z, depth) => {  // whether anything in it is occupied
    if (at + 2 > bytes.length) throw new Error("the octree is cut short");
    const bits = bytes[at] | bytes[at + 1] << 8, edge = 2 ** (TREE_DEPTH - depth - 1);
    let isOccupied = false;
    at += 2;
    for (let child = 0; child < 8; ++child) {
      const state = bits >> (2 * child) & 3;
      const place = [x + (child & 1) * edge, y + (child >> 1 & 1) * edge, z + (child >> 2) * edge];
      if (state === INNER && depth + 1 >= TREE_DEPTH) throw new Error("the octree is damaged");
      const has = state === OCCUPIED_LEAF || state === INNER && node(...place, depth + 1);
      isOccupied = isOccupied || has;
      if (has && (depth + 1 === maxDepth || depth + 1 < maxDepth && state === OCCUPIED_LEAF)) found(...place, edge);
    }
    return isOccupied;
  };
  node(0, 0, 0, 0);
}

// {cubes: x, y, z of the middle and edge (m) of each, depth}: the finest depth that has at most so many.
function cubesOf(bytes, most = MAX_CUBES) {
  const header = octreeHeader(bytes), half = 2 ** (TREE_DEPTH - 1);
  for (let depth = TREE_DEPTH; !header.isEmpty && depth > 0; --depth) {
    let count = 0;
    occupiedLeaves(bytes, header.start, depth, () => ++count);
    if (count > most) continue;
    const cubes = new Float32Array(4 * count);
    let next = 0;
    occupiedLeaves(bytes, header.start, depth, (x, y, z, edge) => {
      for (const lower of [x, y, z]) cubes[next++] = (lower + edge / 2 - half) * header.resolution_m;
      cubes[next++] = edge * header.resolution_m;
    });
    return {cubes, depth};
  }
  return {cubes: new Float32Array(0), depth: 0};
}

const CUBES_VERTEX = `
attribute vec4 cube; uniform float top_m, low_m, high_m; varying vec3 shown;
void main() {
  vec3 place = cube.xyz + position * cube.w;
  float share = clamp((cube.z - low_m) / max(0.01, high_m - low_m), 0.0, 1.0);
  vec3 color = share < 0.5 ? mix(vec3(0.25, 0.32, 0.71), vec3(0.0, 0.59, 0.53), 2.0 * share)
                           : mix(vec3(0.0, 0.59, 0.53), vec3(0.99, 0.85, 0.21), 2.0 * share - 1.0);
  shown = color * (0.72 + 0.28 * normal.z + 0.1 * normal.x);
  gl_Position = cube.z > top_m ? vec4(0.0, 0.0, 2.0, 1.0) : projectionMatrix * modelViewMatrix * vec4(place, 1.0);
}`;

class Octree {
  constructor(layer, bytes) {
    Object.assign(this, cubesOf(bytes));
    const box = new THREE.BoxBufferGeometry(1, 1, 1), geometry = new THREE.InstancedBufferGeometry();
    geometry.index = box.index;
    for (const name of ["position", "normal"]) geometry.setAttribute(name, box.attributes[name]);
    geometry.setAttribute("cube", new THREE.InstancedBufferAttribute(this.cubes, 4));
    geometry.maxInstancedCount = this.cubes.length / 4;
    const heights = this.cubes.filter((_, i) => i % 4 === 2).sort(), at = share => heights[Math.floor(share * (heights.length - 1))] || 0;
    const uniforms = {top_m: {value: 0}, low_m: {value: at(0.01)}, high_m: {value: at(0.99)}};
    const material = new THREE.ShaderMaterial({vertexShader: CUBES_VERTEX, fragmentShader: POINTS_FRAGMENT, uniforms});
    this.object = new THREE.Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.visible = this.cubes.length > 0;
  }

  prepare(look) {
    this.object.material.uniforms.top_m.value = look.top_m;
  }

  // Where a ray enters the first cube; null where it meets none.
  pick(ray, at, look) {
    const origin = ray.origin.toArray(), way = ray.direction.toArray();
    let nearest = Infinity;
    for (let i = 0; i < this.cubes.length; i += 4) {
      const half = this.cubes[i + 3] / 2;
      let enter = 0, leave = nearest;
      if (this.cubes[i + 2] > look.top_m) continue;
      for (let axis = 0; axis < 3; ++axis) {
        const a = (this.cubes[i + axis] - half - origin[axis]) / way[axis], b = (this.cubes[i + axis] + half - origin[axis]) / way[axis];
        enter = Math.max(enter, Math.min(a, b));
        leave = Math.min(leave, Math.max(a, b));
      }
      if (enter > 0 && enter < leave) nearest = enter;
    }
    return nearest < Infinity ? ray.at(nearest, new THREE.Vector3()) : null;
  }
}
