// SPDX-License-Identifier: Apache-2.0
// Layers that are few shapes: the way, loops, things, located queries, grids.
"use strict";

const COLORS = {way: "#1f77d0", accepted: "#2ca02c", rejected: "#d62728", things: "#c2185b", queries: "#e67e00"};
const VIEW_DEPTH_M = 0.45, IN_THE_WAY_M = 1.2, SCAN_M = 0.9, BOX_EDGES = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];
const FRONT_M = 0.3, BELOW_M = 0.01, EYE_M = 1;  // so much a scan's view is above its place (scene_layers.py)

// A layer: `object` to draw, `names` with their places, perhaps `pick`.
class Shapes {
  constructor(objects, names = []) {
    this.object = new THREE.Group();
    this.names = names;
    if (objects.length) this.object.add(...objects);
  }
}

const joined = (corners, edges) => edges.flatMap(i => corners[i].toArray());

function wayLayer(layer) {
  return new Shapes([lines(segmentsOf(layer.points), COLORS.way, 2.5)], [{text: "start", place: vectors(layer.points.slice(0, 3))[0]}]);
}

function loopsLayer(layer) {
  const isAccepted = layer.name === "loops_accepted";
  return new Shapes([lines(layer.segments.flat(), isAccepted ? COLORS.accepted : COLORS.rejected, isAccepted ? 1.8 : 1)]);
}

// Boxes with their names, and an arrow out of the front of each.
function thingsLayer(layer) {
  const segments = [], names = [];
  for (const thing of layer.things) {
    const centre = new THREE.Vector3(...thing.centre), turn = new THREE.Matrix4().makeRotationZ(thing.heading);
    const at = (x, y, z) => new THREE.Vector3(x * thing.half[0], y * thing.half[1], z * thing.half[2]).applyMatrix4(turn).add(centre);
    const corners = Array.from({length: 8}, (_, i) => at(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    segments.push(...joined(corners, BOX_EDGES));
    const front = at(1, 0, 0), tip = front.clone().add(new THREE.Vector3(FRONT_M, 0, 0).applyMatrix4(turn));
    segments.push(...arrow(front, tip));
    names.push({text: thing.name, place: at(0, 0, 1)});
  }
  return new Shapes([lines(segments, COLORS.things, 1.8)], names);
}

function arrow(from, to) {
  const along = to.clone().sub(from), beside = new THREE.Vector3(-along.y, along.x, 0).multiplyScalar(0.2);
  const back = to.clone().addScaledVector(along, -0.3);
  return [from, to, back.clone().add(beside), to, back.clone().sub(beside), to].flatMap(place => place.toArray());
}

function scansLayer(layer) {
  const segments = layer.scans.flatMap(({view: [x, y, z, ...ahead]}) => {
    const from = new THREE.Vector3(x, y, z - EYE_M), to = from.clone().addScaledVector(new THREE.Vector3(...ahead), SCAN_M);
    return arrow(from, to);
  });
  return new Shapes([lines(segments, COLORS.queries, 4)], layer.scans.map(({view, name}) => ({text: name, place: new THREE.Vector3(...view)})));
}

// Pictures at the rays of their cameras, but for those that the eye is near: they would be in its way.
class Pictures extends Shapes {
  // changed: called when a picture is there.
  constructor(layer, changed) {
    const eyes = layer.pictures.map(({place}) => new THREE.Vector3(...place));
    super(layer.pictures.map(({axes, slopes, picture}, i) => {
      const [right, down, ahead] = vectors(axes), group = new THREE.Group();
      const at = (x, y) => eyes[i].clone().addScaledVector(ahead, VIEW_DEPTH_M).addScaledVector(right, x * slopes[0] * VIEW_DEPTH_M)
                                  .addScaledVector(down, y * slopes[1] * VIEW_DEPTH_M);
      const corners = [at(-1, 1), at(1, 1), at(1, -1), at(-1, -1), eyes[i]];
      group.add(lines(joined(corners, [0, 1, 1, 2, 2, 3, 3, 0, 0, 4, 1, 4, 2, 4, 3, 4]), COLORS.queries, 1.5));
      if (picture) group.add(pictured(corners, picture, changed));
      return group;
    }));
    this.eyes = eyes;
  }

  prepare(look) {
    this.object.children.forEach((group, i) => { group.visible = this.eyes[i].distanceTo(look.camera.position) > IN_THE_WAY_M; });
  }
}

// A picture with its four corners, counter-clockwise from the lower left.
function pictured(corners, source, changed, isSharp = false) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners.slice(0, 4).flatMap(place => place.toArray())), 3));
  geometry.setAttribute("uv", new THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const image = new Image(), texture = new THREE.Texture(image);
  texture.generateMipmaps = false;
  texture.minFilter = THREE.LinearFilter;
  texture.magFilter = isSharp ? THREE.NearestFilter : THREE.LinearFilter;
  const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({map: texture, side: THREE.DoubleSide, alphaTest: isSharp ? 0.5 : 0}));
  mesh.visible = false;
  image.onload = () => {
    texture.needsUpdate = mesh.visible = true;
    changed();
  };
  image.src = source;
  return mesh;
}

class Grids extends Shapes {
  constructor(layer, changed) {
    const planes = layer.planes.map(plane => {
      const [x, y, z] = plane.corner, [cos, sin] = [Math.cos(plane.yaw), Math.sin(plane.yaw)];
      const at = (u, v) => new THREE.Vector3(x + cos * u - sin * v, y + sin * u + cos * v, z - BELOW_M);
      const [width, height] = plane.size;
      return [at(0, 0), at(width, 0), at(width, height), at(0, height)];
    });
    super(planes.map((corners, i) => pictured(corners, layer.planes[i].picture, changed, true)));
    this.planes = planes;
  }

  // The place of the grid that a ray meets first.
  pick(ray, at, look) {
    const hits = this.planes.filter(([corner]) => corner.z <= look.top_m).flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]])
                            .map(corners => ray.intersectTriangle(...corners, false, new THREE.Vector3())).filter(Boolean);
    hits.sort((p, q) => p.distanceTo(ray.origin) - q.distanceTo(ray.origin));
    return hits.length ? hits[0].setZ(hits[0].z + BELOW_M) : null;
  }

  prepare(look) {
    this.object.children.forEach((mesh, i) => { mesh.material.visible = this.planes[i][0].z <= look.top_m; });
  }
}
