// SPDX-License-Identifier: Apache-2.0
// Clicks measure: the first gives the place of a point, the second the distance to another; Esc clears.
"use strict";

const CLICK_PX = 5, MARK_COLOR = "#ff2d95", DECIMALS = 3;

class Measure {
  // view: pick(x, y), scene, render(). element: for the text.
  constructor(view, element) {
    this.view = view;
    this.element = element;
    this.places = [];
    this.names = [];
    this.pressed = null;
    const canvas = view.canvas;
    canvas.addEventListener("pointerdown", event => { this.pressed = event.isPrimary && event.button === 0 ? event : null; }, true);
    canvas.addEventListener("pointerup", event => this.released(event), true);
    canvas.addEventListener("keydown", event => { if (event.key === "Escape") this.clear(); });
  }

  released(event) {
    const began = this.pressed;
    this.pressed = null;
    if (!began || !event.isPrimary || Math.hypot(event.clientX - began.clientX, event.clientY - began.clientY) > CLICK_PX) return;
    const box = this.view.canvas.getBoundingClientRect(), place = this.view.pick(event.clientX - box.left, event.clientY - box.top);
    if (!place) return;
    if (this.places.length === 2) this.places = [];
    this.places.push(place);
    this.show();
  }

  clear() {
    this.places = [];
    this.show();
  }

  show() {
    if (this.mesh) this.view.scene.remove(this.mesh);
    this.mesh = null;
    this.names.forEach(name => this.view.names.forget(name));
    this.names = this.places.map((place, i) => ({text: "AB"[i], place}));
    const [a, b] = this.places;
    if (a) {
      const cross = this.places.flatMap(place => this.cross(place));
      this.mesh = lines(b ? [...cross, ...a.toArray(), ...b.toArray()] : cross, MARK_COLOR, 2.5, true);
      this.view.scene.add(this.mesh);
    }
    this.element.replaceChildren(...this.places.map((place, i) => this.line("AB"[i], place)));
    if (b) {
      const text = `${a.distanceTo(b).toFixed(DECIMALS)} m`, way = b.clone().sub(a);
      this.names.push({text, place: a.clone().add(b).divideScalar(2)});
      const said = document.createElement("output");
      said.className = "scene-distance";
      said.textContent = `A to B: ${text} (level ${Math.hypot(way.x, way.y).toFixed(DECIMALS)} m, up ${way.z.toFixed(DECIMALS)} m)`;
      this.element.append(said);
    }
    this.view.render();
  }

  // Three short lines of the length of a fixed share of the distance to the eye.
  cross(place) {
    const half = 0.012 * place.distanceTo(this.view.eye.camera.position);
    return [[half, 0, 0], [0, half, 0], [0, 0, half]].flatMap(way => [-1, 1].flatMap(side => place.toArray().map((at, i) => at + side * way[i])));
  }

  line(name, place) {
    const label = document.createElement("label"), said = document.createElement("output"), copy = document.createElement("button");
    said.className = "scene-place";
    said.textContent = place.toArray().map(metres => metres.toFixed(DECIMALS)).join(", ");
    copy.type = "button";
    copy.textContent = "Copy";
    copy.setAttribute("aria-label", `Copy the place ${name}`);
    copy.dataset.copy = said.textContent;  // page.js copies it
    label.append(`${name} (x, y, z in m): `, said);
    const both = document.createElement("span");
    both.append(label, " ", copy);
    return both;
  }
}
