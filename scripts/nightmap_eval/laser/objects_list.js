// SPDX-License-Identifier: Apache-2.0
// The list beside the map: a group of fields per object. Rows stay where they are when values change, so that the keyboard's
// focus stays too.

const FIELDS = [["name", "Name"], ["x_m", "x (m)"], ["y_m", "y (m)"], ["size_x_m", "Size x (m)"], ["size_y_m", "Size y (m)"],
                ["angle_deg", "Angle (deg)"]];

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
