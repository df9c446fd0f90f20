// SPDX-License-Identifier: Apache-2.0
// The map with its rectangles as an SVG in metres, and the list beside it: what they show, and where on the map the mouse is.

const SVG = "http://www.w3.org/2000/svg";
const HANDLE_PX = 6, TURN_HANDLE_PX = 26, LABEL_PX = 12, MARGIN_M = 0.5;
const CORNERS = [[-1, -1], [1, -1], [1, 1], [-1, 1]];

function turned([x, y], angleDeg) {
  const angle = angleDeg * Math.PI / 180, cos = Math.cos(angle), sin = Math.sin(angle);
  return [cos * x - sin * y, sin * x + cos * y];
}

function svgElement(name, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

class ObjectMap {
  // grid: see report_laser.py.
  constructor(svg, grid) {
    this.svg = svg;
    this.grid = grid;
    // The map's y points up, that of an SVG down.
    const image = svgElement("image", { href: grid.png, width: grid.columns, height: grid.rows, transform: this.imageToMap() });
    this.shapes = svgElement("g");
    svg.append(svgElement("g", { transform: "scale(1 -1)" }, image, this.shapes));
    this.showAll();
  }

  imageToMap() {
    const { origin_x_m, origin_y_m, origin_yaw_rad, resolution_m, rows } = this.grid;
    return `translate(${origin_x_m} ${origin_y_m}) rotate(${origin_yaw_rad * 180 / Math.PI}) ` +
           `scale(${resolution_m} ${-resolution_m}) translate(0 ${-rows})`;
  }

  showAll() {
    const { origin_x_m, origin_y_m, origin_yaw_rad, resolution_m, columns, rows } = this.grid;
    const corners = [[0, 0], [columns, 0], [columns, rows], [0, rows]].map(([column, row]) =>
      turned([column * resolution_m, row * resolution_m], origin_yaw_rad * 180 / Math.PI));
    const xs = corners.map(([x]) => x + origin_x_m), ys = corners.map(([, y]) => -(y + origin_y_m));
    const left = Math.min(...xs) - MARGIN_M, top = Math.min(...ys) - MARGIN_M;
    this.setView({ left, top, width: Math.max(...xs) + MARGIN_M - left, height: Math.max(...ys) + MARGIN_M - top });
  }

  // view: the part of the plane that is shown, in metres, y downwards.
  setView(view) {
    this.view = view;
    this.svg.setAttribute("viewBox", [view.left, view.top, view.width, view.height].join(" "));
  }

  metresPerPixel() {
    const matrix = this.svg.getScreenCTM();
    return matrix ? 1 / matrix.a : this.view.width / 600;
  }

  // Map coordinates of a mouse event.
  position(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [point.x, -point.y];
  }

  centre() {
    return [this.view.left + this.view.width / 2, -(this.view.top + this.view.height / 2)];
  }

  zoom(factor, [x, y]) {
    const width = this.view.width * factor;
    if (width < 4 * this.grid.resolution_m || width > 1e4) return;
    const left = x + (this.view.left - x) * factor, top = -y + (this.view.top + y) * factor;
    this.setView({ left, top, width, height: this.view.height * factor });
  }

  pan(x, y) {
    this.setView({ ...this.view, left: this.view.left - x, top: this.view.top + y });
  }

  draw(objects, selected) {
    const pixel = this.metresPerPixel();
    const order = objects.map((_, index) => index).filter((index) => index !== selected);
    if (selected !== null) order.push(selected);  // above the others, so that its handles can be reached
    this.shapes.replaceChildren(...order.map((index) => this.shape(objects[index], index, index === selected, pixel)));
  }

  shape(object, index, isSelected, pixel) {
    const [half_x, half_y] = [object.size_x_m / 2, object.size_y_m / 2];
    const label = svgElement("text", { "font-size": LABEL_PX * pixel, transform: `rotate(${-object.angle_deg}) scale(1 -1)`,
                                       "stroke-width": 3 * pixel }, object.name);
    const group = svgElement("g", { class: isSelected ? "object selected" : "object", "data-index": index,
                                    transform: `translate(${object.x_m} ${object.y_m}) rotate(${object.angle_deg})` },
      svgElement("rect", { x: -half_x, y: -half_y, width: object.size_x_m, height: object.size_y_m }),
      svgElement("line", { x1: 0, x2: half_x, y1: 0, y2: 0 }), label);
    if (isSelected) {
      const turn_x = half_x + TURN_HANDLE_PX * pixel;
      group.append(svgElement("line", { x1: half_x, x2: turn_x, y1: 0, y2: 0 }), this.handle("turn", turn_x, 0, pixel));
      CORNERS.forEach(([x, y], corner) => group.append(this.handle(corner, x * half_x, y * half_y, pixel)));
    }
    return group;
  }

  handle(name, x, y, pixel) {
    return svgElement("circle", { class: "handle", "data-handle": name, cx: x, cy: y, r: HANDLE_PX * pixel });
  }
}

const FIELDS = [["name", "Name"], ["x_m", "x (m)"], ["y_m", "y (m)"], ["size_x_m", "Size x (m)"], ["size_y_m", "Size y (m)"],
                ["angle_deg", "Angle (deg)"]];

// The list beside the map: a group of fields per object. Rows stay where they are when values change, so that the keyboard's
// focus stays too.
// events: selected(index), edited(index, key, text), deleted(index).
class ObjectList {
  constructor(element, events) {
    this.element = element;
    this.events = events;
    this.rows = [];
  }

  show(objects, selected) {
    while (this.rows.length > objects.length) this.rows.pop().element.remove();
    while (this.rows.length < objects.length) this.rows.push(this.newRow(this.rows.length));
    objects.forEach((object, index) => this.fill(this.rows[index], object, index === selected));
  }

  // Scrolls the list alone: the page stays where the mouse is.
  reveal(index) {
    if (!this.rows[index]) return;
    const row = this.rows[index].element.getBoundingClientRect(), list = this.element.getBoundingClientRect();
    this.element.scrollTop += Math.max(0, row.bottom - list.bottom) - Math.max(0, list.top - row.top);
  }

  // Whether the user is typing in a field, and has not left it since.
  isTyping(input) {
    return input.shown !== undefined && input.value !== input.shown;
  }

  fill(row, object, isSelected) {
    row.element.classList.toggle("selected", isSelected);
    row.element.setAttribute("aria-label", object.name);
    row.element.setAttribute("aria-current", isSelected);
    row.remove.setAttribute("aria-label", `Delete ${object.name}`);
    for (const [key] of FIELDS) {
      const input = row.inputs[key];
      input.value = input.shown = key === "name" ? object.name : object[key].toFixed(key === "angle_deg" ? 1 : 3);
    }
    row.note.textContent = object.distinctiveness === undefined ? "" : `Distinctiveness ${object.distinctiveness.toFixed(2)}`;
  }

  newRow(index) {
    const row = { element: document.createElement("fieldset"), inputs: {}, remove: document.createElement("button"),
                  note: document.createElement("span") };
    for (const [key, title] of FIELDS) {
      const label = document.createElement("label"), input = document.createElement("input");
      label.append(title + " ", input);
      label.className = key;
      input.type = key === "name" ? "text" : "number";
      if (key !== "name") input.step = key === "angle_deg" ? "1" : "0.05";
      input.addEventListener("change", () => this.events.edited(index, key, input.value));
      row.inputs[key] = input;
      row.element.append(label);
    }
    row.remove.type = "button";
    row.remove.textContent = "Delete";
    row.remove.addEventListener("click", () => this.events.deleted(index));
    row.note.className = "note";
    row.element.append(row.remove, row.note);
    row.element.addEventListener("focusin", () => this.events.selected(index));
    this.element.append(row.element);
    return row;
  }
}
