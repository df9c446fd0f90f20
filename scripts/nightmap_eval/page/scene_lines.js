// SPDX-License-Identifier: Apache-2.0
// Straight lines of a width in pixels: WebGL itself draws lines of one pixel alone.
"use strict";

const LINES_VERTEX = `
attribute vec3 start, end; uniform vec2 size_px; uniform float width_px, near_m;
void main() {
  vec4 a = modelViewMatrix * vec4(start, 1.0), b = modelViewMatrix * vec4(end, 1.0);
  if (a.z > -near_m && b.z > -near_m) { gl_Position = vec4(0.0, 0.0, 2.0, 1.0); return; }
  if (a.z > -near_m) a = mix(b, a, (-near_m - b.z) / (a.z - b.z));
  if (b.z > -near_m) b = mix(a, b, (-near_m - a.z) / (b.z - a.z));
  vec4 p = projectionMatrix * a, q = projectionMatrix * b;
  vec2 along = (q.xy / q.w - p.xy / p.w) * size_px;
  along = length(along) < 1e-6 ? vec2(1.0, 0.0) : normalize(along);
  vec4 place = position.x < 0.5 ? p : q;
  vec2 off = vec2(-along.y, along.x) * position.y + along * (position.x - 0.5);  // ends are longer by half the width
  place.xy += off * width_px * 2.0 / size_px * place.w;
  gl_Position = place;
}`;
const LINES_FRAGMENT = "uniform vec3 color; void main() { gl_FragColor = vec4(color, 1.0); }";

// A mesh of segments: six numbers each. Its onBeforeRender keeps the width.
function lines(segments, color, width_px, isOnTop = false) {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array([0, -0.5, 0, 1, -0.5, 0, 1, 0.5, 0, 0, 0.5, 0]), 3));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const both = new THREE.InstancedInterleavedBuffer(Float32Array.from(segments), 6, 1);
  geometry.setAttribute("start", new THREE.InterleavedBufferAttribute(both, 3, 0));
  geometry.setAttribute("end", new THREE.InterleavedBufferAttribute(both, 3, 3));
  geometry.maxInstancedCount = segments.length / 6;
  const uniforms = {size_px: {value: new THREE.Vector2(1, 1)}, width_px: {value: width_px}, near_m: {value: 0.05},
                    color: {value: new THREE.Color(color)}};
  const material = new THREE.ShaderMaterial({vertexShader: LINES_VERTEX, fragmentShader: LINES_FRAGMENT, uniforms,
                                             side: THREE.DoubleSide, depthTest: !isOnTop, depthWrite: !isOnTop});
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.renderOrder = isOnTop ? 2 : 1;
  mesh.onBeforeRender = renderer => {
    renderer.getDrawingBufferSize(uniforms.size_px.value);
    uniforms.width_px.value = width_px * renderer.getPixelRatio();
  };
  return mesh;
}

// Segments of a way through points: three numbers each.
function segmentsOf(points) {
  const segments = [];
  for (let i = 3; i < points.length; i += 3) segments.push(...points.slice(i - 3, i + 3));
  return segments;
}
