// SPDX-License-Identifier: Apache-2.0
// Gestures of the mouse on the map of ObjectsEditor: one lasts from the press of a button to its release.

const LEFT = 0;
const PLACE_DIGITS = 2;  // of metres

function isFar(event, pressed) {
  return Math.max(Math.abs(event.clientX - pressed.clientX), Math.abs(event.clientY - pressed.clientY)) > CLICK_PX;
}

Object.assign(ObjectsEditor.prototype, {
  bindMouse() {
    const svg = this.part("svg");
    svg.addEventListener("mousedown", (event) => this.beginGesture(event));
    svg.addEventListener("contextmenu", (event) => event.preventDefault());  // the right button moves the map
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1);
      this.map.zoom(ZOOM_PER_PX ** Math.max(-500, Math.min(500, pixels)), this.map.position(event));
      this.map.draw(this.objects, this.selected);
    }, { passive: false });
    addEventListener("mousemove", (event) => {
      if (!this.gesture) return;
      if (event.buttons === 0) {  // released outside of the window
        this.endGesture();
        return;
      }
      this.gesture.isDrag ||= isFar(event, this.gesture.pressed);
      this.gesture.move(event);
    });
    addEventListener("mouseup", (event) => {
      if (!this.gesture || event.button !== this.gesture.button) return;
      const { pressed, isDrag } = this.gesture;
      this.endGesture();
      if (!isDrag && !isFar(event, pressed) && event.button === LEFT && !this.panning) this.part(".near").value = `NEAR="${this.place(event).join(",")}"`;
    });
    svg.addEventListener("mousemove", (event) => {
      const [x, y] = this.place(event);
      this.part(".where").textContent = `x ${x} m, y ${y} m`;
    });
    svg.addEventListener("mouseleave", () => { this.part(".where").textContent = ""; });
    this.part(".near").addEventListener("focus", (event) => event.target.select());
  },

  // Map coordinates of a mouse event, as text.
  place(event) {
    return this.map.position(event).map((metres) => metres.toFixed(PLACE_DIGITS));
  },

  beginGesture(event) {
    event.preventDefault();
    this.part("svg").focus({ preventScroll: true });  // ends the typing in a field
    if (this.gesture) return;
    const shape = event.target.closest(".object"), handle = event.target.dataset.handle;
    const start = { before: this.snapshot(), selected: this.selected, button: event.button, pressed: event };
    if (event.button !== LEFT || this.panning) {
      this.gesture = { ...start, move: this.panFrom(event) };
      return;
    }
    this.say("");
    this.select(shape ? Number(shape.dataset.index) : null);
    this.list.reveal(this.selected);
    const object = this.objects[this.selected];
    const move = !shape ? this.drawFrom(event)
      : handle === "turn" ? this.turn(object)
      : handle ? this.resizeBy(object, CORNERS[handle])
      : this.moveFrom(event, object);
    this.gesture = { ...start, move: (moved) => { move(moved); this.show(); } };
  },

  endGesture(isCancelled = false) {
    const { before, selected } = this.gesture;
    this.gesture = null;
    if (isCancelled) [this.objects, this.selected] = [before, selected];
    this.forgetDistinctiveness(before);
    this.commit(before);
    this.list.reveal(this.selected);
  },

  panFrom(event) {
    const [start_x, start_y] = this.map.position(event);
    return (moved) => {
      const [x, y] = this.map.position(moved);
      this.map.pan(x - start_x, y - start_y);
    };
  },

  drawFrom(event) {
    const start = this.map.position(event);
    let object = null;
    return (moved) => {
      const far = Math.min(Math.abs(moved.clientX - event.clientX), Math.abs(moved.clientY - event.clientY)) > CLICK_PX;
      if (!object && !far) return;
      object ??= this.add(start, MIN_SIZE_M, MIN_SIZE_M);
      this.spanFrom(object, start, this.map.position(moved), null);
    };
  },

  moveFrom(event, object) {
    const start = this.map.position(event), { x_m, y_m } = object;
    return (moved) => {
      const [x, y] = this.map.position(moved);
      [object.x_m, object.y_m] = [x_m + x - start[0], y_m + y - start[1]];
    };
  },

  resizeBy(object, corner) {
    const [x, y] = turned([-corner[0] * object.size_x_m / 2, -corner[1] * object.size_y_m / 2], object.angle_deg);
    const fixed = [object.x_m + x, object.y_m + y];  // the corner opposite
    return (moved) => this.spanFrom(object, fixed, this.map.position(moved), corner);
  },

  // Spans the rectangle from a corner that stays to the mouse. corner: signs of the corner that moves; null: any.
  spanFrom(object, fixed, [x, y], corner) {
    const along = turned([x - fixed[0], y - fixed[1]], -object.angle_deg);
    const signs = corner ?? along.map((length) => (length < 0 ? -1 : 1));
    this.say("");
    [object.size_x_m, object.size_y_m] = along.map((length, axis) => this.clampedSize(length * signs[axis]));
    const [to_x, to_y] = turned([signs[0] * object.size_x_m / 2, signs[1] * object.size_y_m / 2], object.angle_deg);
    [object.x_m, object.y_m] = [fixed[0] + to_x, fixed[1] + to_y];
  },

  turn(object) {
    return (moved) => {
      const [x, y] = this.map.position(moved);
      const angle_deg = Math.atan2(y - object.y_m, x - object.x_m) * 180 / Math.PI;
      object.angle_deg = moved.shiftKey ? TURN_STEP_DEG * Math.round(angle_deg / TURN_STEP_DEG) : angle_deg;
    };
  },
});
