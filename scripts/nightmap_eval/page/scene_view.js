// SPDX-License-Identifier: Apache-2.0
// The view: layers with their checkboxes, drawn when something has changed; coarser while the eye moves.
"use strict";

const REST_MS = 200, MAX_PIXEL_RATIO = 2, SLIDER_STEPS = 1000, SAME_POINTS = ["colors", "labels"];

class View {
  constructor(root, data) {
    this.root = root;
    this.data = data;
    this.canvas = root.querySelector("canvas");
    this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, antialias: true});
    this.scene = new THREE.Scene();
    this.layers = data.layers.map(layer => ({...layer, content: null, loading: null}));
    this.names = new Names(root.querySelector(".scene-names"));
    this.eye = new Eye(this.canvas, data, () => this.moved());
    this.measure = new Measure(this, root.querySelector(".scene-measured"));
    this.top_m = Infinity;
    this.hidesBacks = true;
    this.isMoving = false;
    this.isWaiting = false;
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.addEventListener("change", () => this.render());
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    this.canvas.addEventListener("webglcontextrestored", () => this.render());
    this.addLayers();
    this.addControls();
    this.resize();
    this.eye.go("whole");
  }

  addLayers() {
    const boxes = this.root.querySelector(".scene-layers").elements;
    for (const layer of this.layers) {
      layer.box = boxes.namedItem(layer.name);
      layer.box.disabled = layer.kind === "absent";
      layer.box.addEventListener("change", () => this.choose(layer, layer.box));
    }
  }

  addControls() {
    for (const button of this.root.querySelectorAll("[data-view]"))
      button.addEventListener("click", () => this.go(button.dataset.view));
    const way = this.root.querySelector(".scene-way input"), count = this.data.views.length;
    way.max = Math.max(0, count - 1);
    way.addEventListener("input", () => this.eye.follow(this.data.views[Number(way.value)]));
    this.root.querySelector("[data-view=robot]").hidden = count === 0;
    const cut = this.root.querySelector(".scene-cut input"), said = this.root.querySelector(".scene-cut output");
    cut.addEventListener("input", () => {
      const [low, high] = [this.data.bounds[2], this.data.bounds[5]];
      this.top_m = Number(cut.value) === SLIDER_STEPS ? Infinity : low + (high - low) * cut.value / SLIDER_STEPS;
      said.textContent = this.top_m === Infinity ? "" : `${this.top_m.toFixed(2)} m`;
      this.moved();
    });
    const backs = this.root.querySelector(".scene-backs input");
    backs.addEventListener("change", () => {
      this.hidesBacks = backs.checked;
      this.render();
    });
  }

  go(name) {
    this.root.querySelector(".scene-way").hidden = name !== "robot";
    if (name === "robot") this.eye.follow(this.data.views[Number(this.root.querySelector(".scene-way input").value)]);
    else this.eye.go(name);
  }

  // Loads all layers that are on. Rejects with the first error.
  async load() {
    await Promise.all(this.layers.filter(layer => layer.on).map(layer => this.turn(layer, true)));
  }

  // One at most is on, of the clouds that show the same points.
  choose(layer, box) {
    for (const other of this.layers.filter(({name}) => box.checked && SAME_POINTS.includes(layer.name) && SAME_POINTS.includes(name)))
      if (other !== layer && other.on) {
        other.box.checked = false;
        this.turn(other, false);
      }
    this.turn(layer, box.checked);
  }

  async turn(layer, isOn) {
    layer.on = isOn;
    if (isOn && !layer.content) {
      layer.loading = layer.loading || this.contentOf(layer);
      try {
        const content = await layer.loading;
        if (!layer.content) this.scene.add(content.object);
        layer.content = content;
      } catch (error) {
        say(this.root, `${layer.title}: ${error.message}`);
        return;
      }
      this.root.querySelector(".scene-backs").hidden = !this.layers.some(({content}) => content && content.hasNormals);
    }
    if (layer.classes) this.showClasses(layer);
    this.render();
  }

  async contentOf(layer) {
    const redraw = () => this.render();
    switch (layer.kind) {
      case "cloud": return new Points(layer, await bytesOf(layer.text));
      case "octree": return new Octree(layer, await bytesOf(layer.text));
      case "way": return wayLayer(layer);
      case "loops": return loopsLayer(layer);
      case "things": return thingsLayer(layer);
      case "scans": return scansLayer(layer);
      case "pictures": return new Pictures(layer, redraw);
      case "grids": return new Grids(layer, redraw);
      default: throw new Error(`unknown kind of layer: ${layer.kind}`);
    }
  }

  showClasses(layer) {
    const list = this.root.querySelector(".scene-classes");
    list.hidden = !layer.on;
    list.replaceChildren(...layer.classes.map(({name, color}) => {
      const label = document.createElement("label"), swatch = document.createElement("span");
      swatch.className = "swatch";
      swatch.style.background = color;
      label.append(swatch, name);
      return label;
    }));
  }

  shown() {
    return this.layers.filter(layer => layer.on && layer.content);
  }

  look() {
    return {camera: this.eye.camera, width_px: this.canvas.clientWidth, height_px: this.canvas.clientHeight,
            pixelRatio: this.renderer.getPixelRatio(), top_m: this.top_m, hidesBacks: this.hidesBacks, isMoving: this.isMoving};
  }

  resize() {
    const box = this.canvas.parentElement;
    if (!box.clientWidth || !box.clientHeight) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, MAX_PIXEL_RATIO));
    this.renderer.setSize(box.clientWidth, box.clientHeight, false);
    this.eye.fit(box.clientWidth, box.clientHeight);
    if (this.eye.shown) this.eye.go(this.eye.shown);
    this.render();
  }

  moved() {
    this.isMoving = true;
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.isMoving = false;
      this.render();
    }, REST_MS);
    this.render();
  }

  // At the next frame; once, however often it is asked for.
  render() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.draw();
    });
  }

  draw() {
    if (!this.canvas.clientWidth) return;
    this.eye.fit(this.canvas.clientWidth, this.canvas.clientHeight);
    const look = this.look();
    for (const layer of this.layers)
      if (layer.content) {
        layer.content.object.visible = layer.on;
        if (layer.on && layer.content.prepare) layer.content.prepare(look);
      }
    this.renderer.setClearColor(getComputedStyle(this.root).getPropertyValue("--stage").trim());
    this.renderer.render(this.scene, this.eye.camera);
    const far = ({place}) => place.distanceToSquared(look.camera.position);
    const names = this.shown().flatMap(layer => layer.content.names || []).sort((a, b) => far(a) - far(b));
    this.names.show([...this.measure.names, ...names], look);
  }

  // The nearest place that a layer shows at a pixel of the canvas; null where nothing is.
  pick(x, y) {
    this.draw();
    const look = this.look(), caster = new THREE.Raycaster();
    caster.setFromCamera({x: 2 * x / look.width_px - 1, y: 1 - 2 * y / look.height_px}, look.camera);
    const places = this.shown().map(layer => layer.content.pick ? layer.content.pick(caster.ray, [x, y], look) : null).filter(Boolean);
    places.sort((a, b) => a.distanceTo(look.camera.position) - b.distanceTo(look.camera.position));
    return places[0] || null;
  }

  // The bytes of a fresh picture, four per pixel.
  pixels() {
    this.isMoving = false;
    this.draw();
    const gl = this.renderer.getContext(), [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }
}
