// SPDX-License-Identifier: Apache-2.0
// The plan: zoom, move, layers, floors; clicks tell places and the distance between two of them. Its drawing has y down, the map y up.
"use strict";
const SVG = "http://www.w3.org/2000/svg";
const CLICK_PX = 5, ZOOM = 1.25, PAN = 0.1, SCALE_PX = 120;

class FloorMap {
  constructor(root) {
    this.root = root;
    this.svg = root.querySelector("svg");
    this.readout = root.querySelector(".readout");
    this.picked = root.querySelector(".picked");
    this.floor = root.dataset.floor;
    this.places = [];
    this.pointers = new Map();
    for (const box of root.querySelectorAll("input[type=checkbox]")) box.addEventListener("change", () => this.showLayers());
    const floors = root.querySelector("select");
    if (floors) floors.addEventListener("change", () => this.showFloor(floors.value));
    for (const button of root.querySelectorAll(".zoom button")) button.addEventListener("click", () => this.zoomBy(button.dataset.zoom));
    for (const link of document.querySelectorAll("[data-place]")) link.addEventListener("click", () => this.goTo(link.dataset.place));
    root.querySelector(".layers").open = matchMedia("(min-width: 60rem)").matches;
    this.listen();
    this.showFloor(this.floor);
    addEventListener("resize", () => this.applyView());
    addEventListener("beforeprint", () => this.fit());
  }

  listen() {
    this.svg.addEventListener("pointerdown", (event) => this.down(event));
    this.svg.addEventListener("pointermove", (event) => this.move(event));
    this.svg.addEventListener("pointerup", (event) => this.up(event));
    this.svg.addEventListener("pointercancel", (event) => this.pointers.delete(event.pointerId));
    this.svg.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.svg.addEventListener("keydown", (event) => this.key(event));
  }

  // ---- floors and layers ----

  showFloor(floor) {
    this.floor = floor;
    this.places = [];
    this.showLayers();
    this.fit();
    this.tell();
  }

  showLayers() {
    const shown = new Set([...this.root.querySelectorAll("input:checked")].map((box) => box.value));
    for (const layer of this.svg.querySelectorAll("[data-layer]")) {
      const isShown = layer.dataset.floor === this.floor && shown.has(layer.dataset.layer);
      layer.style.display = isShown ? "" : "none";
    }
  }

  // ---- the view ----

  fit() {
    const [x, y, width, height] = this.root.querySelector(`[data-view-of="${this.floor}"]`).dataset.view.split(" ").map(Number);
    this.view = { x, y, width, height };
    this.applyView();
  }

  applyView() {
    const { x, y, width, height } = this.view;
    this.svg.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
    const box = this.svg.getBoundingClientRect();
    const metresPerPx = Math.max(width / (box.width || 1), height / (box.height || 1));
    this.svg.style.setProperty("--px", metresPerPx);
    this.showScale(metresPerPx);
  }

  // A bar of 1, 2 or 5 times a power of ten metres.
  showScale(metresPerPx) {
    const most = SCALE_PX * metresPerPx, power = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].map((times) => times * power).find((one) => one <= most);
    this.root.querySelector(".scale span").style.width = `${length / metresPerPx}px`;
    this.root.querySelector(".scale output").textContent = `${Number(length.toPrecision(1))} m`;
  }

  zoom(factor, at) {
    const { x, y, width, height } = this.view, middle = at || { x: x + width / 2, y: y + height / 2 };
    this.view = { x: middle.x - (middle.x - x) / factor, y: middle.y - (middle.y - y) / factor, width: width / factor, height: height / factor };
    this.applyView();
  }

  zoomBy(word) {
    if (word === "fit") this.fit();
    else this.zoom(word === "in" ? ZOOM : 1 / ZOOM);
  }

  pan(x, y) {
    this.view.x += x;
    this.view.y += y;
    this.applyView();
  }

  goTo(text) {
    const [x, y, floor] = text.split(" ");
    const select = this.root.querySelector("select");
    if (select) select.value = floor;
    this.showFloor(floor);
    const size = Math.min(6, this.view.width);
    this.view = { x: Number(x) - size / 2, y: -Number(y) - size / 2, width: size, height: size };
    this.applyView();
    this.root.scrollIntoView({ block: "nearest" });
  }

  // A point of the drawing under a point of the window.
  at(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return { x: point.x, y: point.y };
  }

  // ---- mouse, fingers, keys ----

  down(event) {
    if (event.button) return;
    this.svg.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, began: { x: event.clientX, y: event.clientY }, isClick: this.pointers.size === 0 });
  }

  move(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return this.tell(this.at(event));
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, one]) => one);
    const before = this.at({ clientX: pointer.x, clientY: pointer.y }), now = this.at(event);
    if (Math.hypot(event.clientX - pointer.began.x, event.clientY - pointer.began.y) > CLICK_PX || others.length) pointer.isClick = false;
    if (others.length === 1) {
      const apart = (x, y) => Math.max(1, Math.hypot(x - others[0].x, y - others[0].y));
      this.zoom(apart(event.clientX, event.clientY) / apart(pointer.x, pointer.y), this.at({ clientX: others[0].x, clientY: others[0].y }));
    } else if (!pointer.isClick) {
      this.pan(before.x - now.x, before.y - now.y);
    }
    pointer.x = event.clientX;
    pointer.y = event.clientY;
  }

  up(event) {
    const pointer = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (pointer && pointer.isClick) this.pick(this.at(event));
  }

  // A page scrolls by the wheel; the plan zooms by it while it has the focus, or with Control.
  wheel(event) {
    if (document.activeElement !== this.svg && !event.ctrlKey) return;
    event.preventDefault();
    this.zoom(event.deltaY < 0 ? ZOOM : 1 / ZOOM, this.at(event));
  }

  key(event) {
    const step = PAN * this.view.width;
    const keys = {
      ArrowLeft: () => this.pan(-step, 0), ArrowRight: () => this.pan(step, 0), ArrowUp: () => this.pan(0, -step), ArrowDown: () => this.pan(0, step),
      "+": () => this.zoom(ZOOM), "=": () => this.zoom(ZOOM), "-": () => this.zoom(1 / ZOOM), 0: () => this.fit(),
      Enter: () => this.pick({ x: this.view.x + this.view.width / 2, y: this.view.y + this.view.height / 2 }),
      Escape: () => { this.places = []; this.tell(); },
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  }

  // ---- places ----

  pick(place) {
    this.places = this.places.length === 2 ? [place] : [...this.places, place];
    this.tell();
  }

  tell(under) {
    const said = ({ x, y }) => `${x.toFixed(2)},${(-y).toFixed(2)}`;
    const [from, to] = this.places;
    const command = this.root.dataset.command;
    const names = command ? ["START=", " GOAL="] : ["", " and "];
    const words = from ? `${names[0]}"${said(from)}"` + (to ? `${names[1]}"${said(to)}"` : "") : "";
    const floor = this.floor === "0" || !command ? "" : ` SET=plan.floor=${this.floor}`;
    const away = to ? `${Math.hypot(to.x - from.x, to.y - from.y).toFixed(2)} m apart` : "";
    const hint = from ? "" : "Click a place for its coordinates, a second one for the distance. ";
    const here = under ? `here: x ${under.x.toFixed(2)} m, y ${(-under.y).toFixed(2)} m` : "";
    const text = document.createElement("span");
    text.textContent = [words && words + floor, away, hint + here].filter(Boolean).join(" · ");
    this.readout.replaceChildren(text);
    if (words && command) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = to ? "copy the command" : "copy START";
      button.dataset.copy = to ? `${command} ${words}${floor}` : words;
      this.readout.append(" ", button);
    }
    this.draw();
  }

  draw() {
    const make = (name, values) => {
      const element = document.createElementNS(SVG, name);
      for (const [key, value] of Object.entries(values)) element.setAttribute(key, value);
      return element;
    };
    const [from, to] = this.places;
    const line = to ? [make("line", { x1: from.x, y1: from.y, x2: to.x, y2: to.y })] : [];
    this.picked.replaceChildren(...line, ...this.places.map(({ x, y }) => make("circle", { cx: x, cy: y })));
  }
}

for (const root of document.querySelectorAll(".floor-map")) root.floorMap = new FloorMap(root);
