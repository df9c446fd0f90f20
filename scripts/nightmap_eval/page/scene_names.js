// SPDX-License-Identifier: Apache-2.0
// Names above the picture at places of the map: the nearest first, none over another.
"use strict";

const MAX_NAMES = 120;

class Names {
  constructor(element) {
    this.element = element;
    this.spans = new Map();  // of each name that was shown once
  }

  // names: {text, place}, in the order in which they count.
  show(names, look) {
    const shown = new Set(), taken = [], point = new THREE.Vector3();
    for (const name of names) {
      point.copy(name.place).project(look.camera);
      if (shown.size >= MAX_NAMES || point.z < -1 || point.z > 1 || Math.abs(point.x) > 1 || Math.abs(point.y) > 1) continue;
      const span = this.span(name), x = (point.x + 1) / 2 * look.width_px, y = (1 - point.y) / 2 * look.height_px;
      const box = {left: x - span.width / 2, right: x + span.width / 2, top: y - span.height, low: y};
      if (taken.some(other => box.left < other.right && box.right > other.left && box.top < other.low && box.low > other.top)) continue;
      taken.push(box);
      shown.add(name);
      span.node.hidden = false;
      span.node.style.transform = `translate(${box.left.toFixed(1)}px, ${(box.top - 2).toFixed(1)}px)`;
    }
    for (const [name, span] of this.spans) if (!shown.has(name)) span.node.hidden = true;
  }

  span(name) {
    if (!this.spans.has(name)) {
      const node = document.createElement("span");
      node.textContent = name.text;
      this.element.append(node);
      this.spans.set(name, {node, width: node.offsetWidth, height: node.offsetHeight});
    }
    return this.spans.get(name);
  }

  forget(name) {
    if (this.spans.has(name)) this.spans.get(name).node.remove();
    this.spans.delete(name);
  }
}
