// SPDX-License-Identifier: Apache-2.0
// The eye of the view: it orbits by mouse and touch (OrbitControls), flies by keys, and goes to views of the whole or of the robot.
"use strict";

const FIELD_DEG = 55, NEAR_M = 0.05, ROBOT_TARGET_M = 1.5, FILLED = 0.9, FIT_ROUNDS = 8, LEAST_DISTANCE_M = 0.5;
const DIRECTIONS = {whole: [-0.55, -0.75, 0.75], above: [0, -0.001, 1], side: [0, -1, 0.12]};  // from the middle of the map to the eye
const FLIGHT = {w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, -1, 0], e: [0, 1, 0],
                arrowup: [0, 0, 1], arrowdown: [0, 0, -1], arrowleft: [-1, 0, 0], arrowright: [1, 0, 0]};  // right, up, ahead
const FIRST_FRAME_S = 1 / 60, LONGEST_FRAME_S = 0.1, LEAST_SPEED_M = 1, SPEED = 0.6;  // of the distance to the target, per second

class Eye {
  // bounds, outline: of the scene (scene.py). changed: called after each move.
  constructor(canvas, {bounds, outline}, changed) {
    this.camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, NEAR_M, 1000);
    this.camera.up.set(0, 0, 1);
    this.low = new THREE.Vector3(...bounds.slice(0, 3));
    this.high = new THREE.Vector3(...bounds.slice(3));
    this.outline = vectors(outline);
    this.changed = changed;
    this.held = new Set();
    this.shown = null;  // the name of the view that nobody has left
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = this.controls.enableZoom = false;
    this.controls.screenSpacePanning = true;
    this.controls.minDistance = NEAR_M;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => { this.shown = null; });
    canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    canvas.addEventListener("blur", () => { this.controls.enableZoom = false; this.held.clear(); });
    canvas.addEventListener("touchstart", () => { this.controls.enableZoom = true; }, {capture: true, passive: true});
    canvas.addEventListener("keydown", event => this.pressed(event));
    canvas.addEventListener("keyup", event => this.held.delete(event.key.toLowerCase()));
  }

  // In a direction so near that all of the outline is seen, and in the middle.
  go(name) {
    const target = this.low.clone().add(this.high).divideScalar(2), back = new THREE.Vector3(...DIRECTIONS[name]).normalize();
    const right = new THREE.Vector3(0, 0, 1).cross(back).normalize(), up = back.clone().cross(right);
    const slope = Math.tan(this.camera.fov * Math.PI / 360) * FILLED, slopes = [slope * this.camera.aspect, slope];
    let far = this.low.distanceTo(this.high);
    for (let round = 0; round < FIT_ROUNDS; ++round) {
      const seen = this.outline.map(point => point.clone().sub(target)).map(point => ({point, depth: Math.max(NEAR_M, far - point.dot(back))}));
      [right, up].forEach(axis => {  // to the middle of the outline as it is seen
        const shares = seen.map(({point, depth}) => point.dot(axis) / depth);
        target.addScaledVector(axis, (Math.min(...shares) + Math.max(...shares)) / 2 * far);
      });
      const places = this.outline.map(point => point.clone().sub(target));
      far = Math.max(...places.map(point => point.dot(back) + Math.max(Math.abs(point.dot(right)) / slopes[0], Math.abs(point.dot(up)) / slopes[1])));
      far = Math.max(far, LEAST_DISTANCE_M);
    }
    this.look(target.clone().addScaledVector(back, far), target);
    this.shown = name;
  }

  // view: place and direction, six numbers.
  follow(view) {
    const place = new THREE.Vector3(...view.slice(0, 3)), ahead = new THREE.Vector3(...view.slice(3));
    this.look(place, place.clone().addScaledVector(ahead, ROBOT_TARGET_M));
  }

  look(place, target) {
    this.shown = null;
    this.camera.position.copy(place);
    this.controls.target.copy(target);
    this.controls.update();
    this.changed();
  }

  pressed(event) {
    const key = event.key.toLowerCase();
    if (!FLIGHT[key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const isFlying = this.held.size > 0;
    this.held.add(key);
    if (isFlying) return;
    this.step(FIRST_FRAME_S);
    this.fly(performance.now());
  }

  // Steps at each frame while a key is held.
  fly(before) {
    requestAnimationFrame(now => {
      if (this.held.size === 0) return;
      this.step(Math.min(LONGEST_FRAME_S, Math.max(0, now - before) / 1000));
      this.fly(now);
    });
  }

  step(seconds) {
    const speed = Math.max(LEAST_SPEED_M, SPEED * this.camera.position.distanceTo(this.controls.target));
    const ahead = this.camera.getWorldDirection(new THREE.Vector3()), right = ahead.clone().cross(this.camera.up).normalize();
    const way = new THREE.Vector3();
    for (const key of this.held) {
      const [x, y, z] = FLIGHT[key];
      way.addScaledVector(right, x).addScaledVector(this.camera.up, y).addScaledVector(ahead, z);
    }
    way.setLength(way.length() && speed * seconds);
    this.look(this.camera.position.clone().add(way), this.controls.target.clone().add(way));
  }

  // For a view of this size. The far plane is behind all of the map.
  fit(width_px, height_px) {
    this.camera.aspect = width_px / height_px;
    const size = this.low.distanceTo(this.high);
    this.camera.far = 20 * size + this.camera.position.distanceTo(this.low);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }
}
