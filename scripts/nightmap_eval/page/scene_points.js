// SPDX-License-Identifier: Apache-2.0
// A cloud of points in blocks. Each block is drawn as far as its size on the screen asks for: its first n points are a uniform sample.
"use strict";

const BACK_COSINE = -0.15;  // between where a surface faces and the eye: it is seen from behind
const POINTS_VERTEX = `
attribute vec3 tint; attribute float facing;
uniform float size_m, least_px, height_px, top_m, hides_backs;
varying vec3 shown;
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0), seen = viewMatrix * place;
  float band = floor((facing + 0.5) / 36.0), around = (facing - 36.0 * band) * 0.17453293, up = (band - 3.0) * 0.52359878;
  vec3 normal = vec3(cos(up) * cos(around), cos(up) * sin(around), sin(up));
  bool isBack = hides_backs > 0.5 && facing < 254.5 && dot(normal, normalize(cameraPosition - place.xyz)) < ${BACK_COSINE};
  gl_Position = isBack || place.z > top_m ? vec4(0.0, 0.0, 2.0, 1.0) : projectionMatrix * seen;
  gl_PointSize = clamp(size_m * projectionMatrix[1][1] * 0.5 * height_px / max(0.01, -seen.z), least_px, 40.0);
  shown = tint;
}`;
const POINTS_FRAGMENT = "varying vec3 shown; void main() { gl_FragColor = vec4(shown, 1.0); }";
const PICK_PX = 9, SAME_SURFACE = 0.01;
const POINTS_PER_PX = 1.5, MOVING_SHARE = 0.2;  // of the area of a block on the screen
const LEAST_POINTS = 64, COVER = 1.3;  // so much larger than their spacing are points drawn

class Points {
  constructor(layer, bytes) {
    this.head = layer.cloud;
    this.leastPx = layer.least_px || 1.5;
    this.hasNormals = false;
    const palette = layer.classes && layer.classes.map(entry => rgbOf(entry.color));
    this.object = new THREE.Group();
    this.blocks = blocksOf(bytes, layer.cloud, palette).map(block => this.add(block));
  }

  add(block) {
    const geometry = new THREE.BufferGeometry(), edge = this.head.block_m;
    geometry.setAttribute("position", new THREE.BufferAttribute(block.places, 3, true));
    geometry.setAttribute("tint", new THREE.BufferAttribute(block.tints, 3, true));
    geometry.setAttribute("facing", new THREE.BufferAttribute(block.facings, 1, false));
    geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(0.5, 0.5, 0.5), Math.sqrt(3) / 2);
    const uniforms = {};
    for (const name of ["size_m", "least_px", "height_px", "top_m", "hides_backs"]) uniforms[name] = {value: 0};
    const material = new THREE.ShaderMaterial({vertexShader: POINTS_VERTEX, fragmentShader: POINTS_FRAGMENT, uniforms});
    block.points = new THREE.Points(geometry, material);
    block.points.position.fromArray(block.corner);
    block.points.scale.setScalar(edge);
    block.middle = new THREE.Vector3(...block.corner).addScalar(edge / 2);
    block.drawn = block.count;
    this.hasNormals = this.hasNormals || block.facings.some(facing => facing !== NO_FACING);
    this.object.add(block.points);
    return block;
  }

  // Before each drawing. look: {camera, width_px, height_px, pixelRatio, top_m, hidesBacks, isMoving}.
  prepare(look) {
    const edge = this.head.block_m, scale = look.height_px * look.pixelRatio / 2 * look.camera.projectionMatrix.elements[5];
    for (const block of this.blocks) {
      const far = Math.max(edge / 4, look.camera.position.distanceTo(block.middle) - edge / 2);
      const wanted = POINTS_PER_PX * (edge * scale / far) ** 2 * (look.isMoving ? MOVING_SHARE : 1);
      block.drawn = Math.min(block.count, Math.max(LEAST_POINTS, Math.round(wanted)));
      block.points.geometry.setDrawRange(0, block.drawn);
      const values = {size_m: COVER * this.head.spacing_m * Math.sqrt(block.count / block.drawn), least_px: this.leastPx * look.pixelRatio,
                      height_px: look.height_px * look.pixelRatio, top_m: look.top_m, hides_backs: look.hidesBacks ? 1 : 0};
      for (const name in values) block.points.material.uniforms[name].value = values[name];
    }
  }

  // The point that is drawn nearest to a ray, of those on the foremost surface there; null where none is. Places in pixels of the view.
  pick(ray, at, look) {
    const found = [], edge = this.head.block_m, reach = Math.sqrt(3) / 2 * edge;
    for (const block of this.blocks) {
      const far = ray.origin.distanceTo(block.middle) + reach;
      const radius = reach + PICK_PX * far / (look.height_px / 2 * look.camera.projectionMatrix.elements[5]);
      if (ray.distanceSqToPoint(block.middle) < radius * radius) this.pickIn(block, at, look, found);
    }
    const front = Math.min(...found.map(hit => hit.depth));
    const near = found.filter(hit => hit.depth <= front * (1 + SAME_SURFACE) + this.head.spacing_m);
    near.sort((a, b) => a.away - b.away || a.depth - b.depth);
    return near.length ? near[0].place : null;
  }

  pickIn(block, at, look, found) {
    const matrix = new THREE.Matrix4().multiplyMatrices(look.camera.projectionMatrix, look.camera.matrixWorldInverse).elements;
    const edge = this.head.block_m / PARTS, [x0, y0, z0] = block.corner, eye = look.camera.position;
    for (let i = 0; i < block.drawn; ++i) {
      const x = x0 + block.places[3 * i] * edge, y = y0 + block.places[3 * i + 1] * edge, z = z0 + block.places[3 * i + 2] * edge;
      const depth = matrix[3] * x + matrix[7] * y + matrix[11] * z + matrix[15];
      if (depth <= look.camera.near || z > look.top_m) continue;
      const right = (matrix[0] * x + matrix[4] * y + matrix[8] * z + matrix[12]) / depth;
      const up = (matrix[1] * x + matrix[5] * y + matrix[9] * z + matrix[13]) / depth;
      const away = Math.hypot((right + 1) / 2 * look.width_px - at[0], (1 - up) / 2 * look.height_px - at[1]);
      if (away > PICK_PX || this.isBack(block.facings[i], [eye.x - x, eye.y - y, eye.z - z], look)) continue;
      found.push({away, depth, place: new THREE.Vector3(x, y, z)});
    }
  }

  isBack(facing, toEye, look) {
    if (!look.hidesBacks || facing === NO_FACING) return false;
    const normal = normalOf(facing), cosine = normal[0] * toEye[0] + normal[1] * toEye[1] + normal[2] * toEye[2];
    return cosine < BACK_COSINE * Math.hypot(...toEye);
  }
}
