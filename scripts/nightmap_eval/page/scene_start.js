// SPDX-License-Identifier: Apache-2.0
// Starts the view when its section comes into sight, so that the page opens fast. Kinds of layers: cloud, octree, way, loops, things,
// scans, pictures, grids; absent: a sentence instead.
"use strict";

function say(root, text) {
  const said = root.querySelector(".scene-said");
  said.textContent = text;
  said.hidden = text === "";
}

function needs() {
  const canvas = document.createElement("canvas");
  if (!window.WebGLRenderingContext || !(canvas.getContext("webgl") || canvas.getContext("experimental-webgl")))
    return "This browser shows no 3-D graphics (WebGL): switch on hardware acceleration in its settings, or open the page in another browser.";
  return window.DecompressionStream && window.ResizeObserver ? "" : "This browser is too old for the view: open the page in one of 2023 or later.";
}

function runLibraries() {
  for (const library of document.querySelectorAll(".scene-library")) {
    const script = document.createElement("script");
    script.textContent = library.textContent;
    document.head.append(script);
  }
}

async function start(root) {
  const missing = needs();
  if (missing) throw new Error(missing);
  say(root, "Loading ...");
  await new Promise(done => setTimeout(done));  // shows the sentence
  runLibraries();
  const view = new View(root, JSON.parse(document.getElementById("scene-data").textContent));
  say(root, "");
  await view.load();
  return view;
}

// For tests: what the view has and shows.
class Seen {
  constructor(ready) {
    this.view = null;
    this.ready = ready.then(view => { this.view = view; });
  }

  get layers() {
    return this.view.layers.map(({name, on, content}) => ({name, on, isLoaded: content !== null}));
  }

  get camera() {
    return this.view.eye.camera.position.toArray();
  }

  pick(x, y) {
    const place = this.view.pick(x, y);
    return place && place.toArray();
  }

  // The cubes of the octree, at most so many.
  async cubes(most) {
    return Array.from(cubesOf(await bytesOf("scene-octree"), most).cubes);
  }

  // The pixel of the canvas where a place of the map is.
  pixelOf(place) {
    const {camera, width_px, height_px} = this.view.look(), point = new THREE.Vector3(...place).project(camera);
    return [(point.x + 1) / 2 * width_px, (1 - point.y) / 2 * height_px];
  }

  // The share of pixels that are not background.
  pixelsDrawn() {
    const bytes = this.view.pixels(), [r, g, b] = this.view.renderer.getClearColor().toArray().map(part => Math.round(255 * part));
    let count = 0;
    for (let i = 0; i < bytes.length; i += 4) count += bytes[i] !== r || bytes[i + 1] !== g || bytes[i + 2] !== b;
    return 4 * count / bytes.length;
  }

  // A number that changes with the picture.
  pictureHash() {
    return this.view.pixels().reduce((hash, byte) => Math.imul(hash ^ byte, 16777619) >>> 0, 2166136261);
  }
}

const root = document.getElementById("scene");
window.nightmapScene = new Seen(new Promise((resolve, reject) => {
  const observer = new IntersectionObserver(entries => {
    if (!entries.some(entry => entry.isIntersecting)) return;
    observer.disconnect();
    start(root).then(resolve, reject);
  }, {rootMargin: "200px"});
  observer.observe(root);
}));
window.nightmapScene.ready.catch(error => say(root, error.message));

// On a phone a finger scrolls the page past the view, until the button gives it to the view.
const touch = root.querySelector(".scene-touch"), canvas = root.querySelector("canvas");
touch.addEventListener("click", () => {
  const isGiven = touch.getAttribute("aria-pressed") === "false";
  touch.setAttribute("aria-pressed", String(isGiven));
  canvas.style.pointerEvents = isGiven ? "" : "none";
});
if (matchMedia("(pointer: coarse)").matches) {
  touch.hidden = false;
  canvas.style.pointerEvents = "none";
}
