// SPDX-License-Identifier: Apache-2.0
// The editor of objects: draws, moves, turns, resizes, names and deletes rectangles on the map. Uses objects_file.js
// and objects_map.js, which report_laser.py puts before it.

const CLICK_PX = 4;  // a mouse that moves less does not draw
const MIN_SIZE_M = 0.01, NEW_SIZE_M = 1, TURN_STEP_DEG = 15, ZOOM_PER_PX = 1.0015, MAX_FILE_BYTES = 4e6;

class ObjectsEditor {
  constructor(root, data) {
    this.root = root;
    this.maxSizeM = data.max_size_m;
    this.objects = [];
    this.history = [];
    this.selected = null;
    this.gesture = null;
    this.panning = false;
    this.isSaved = true;
    this.map = new ObjectMap(this.part("svg"), data.grid);
    this.list = new ObjectList(this.part(".list"), {
      selected: (index) => this.select(index),
      edited: (...change) => this.edit(...change),
      deleted: (index) => this.remove(index),
    });
    this.bindButtons(data.files);
    this.bindMouse();
    this.bindFiles();
    root.addEventListener("keydown", (event) => this.key(event));
    addEventListener("beforeunload", (event) => this.isSaved || event.preventDefault());
    if (data.files.length) this.open(data.files[0].text, data.files[0].name);
    this.history = [];
    this.isSaved = true;
    this.show();
  }

  part(selector) {
    return this.root.querySelector(selector);
  }

  say(text, isError = false) {
    const notice = this.part(".notice");
    notice.textContent = text;
    notice.classList.toggle("failed", isError);
  }

  show() {
    this.map.draw(this.objects, this.selected);
    this.list.show(this.objects, this.selected);
    this.part(".undo").disabled = !this.history.length;
    this.part(".count").textContent = this.objects.length === 1 ? "1 object" : `${this.objects.length} objects`;
  }

  select(index) {
    this.selected = index;
    this.show();
  }

  snapshot() {
    return structuredClone(this.objects);
  }

  // Ends a change: what was before can come back.
  commit(before) {
    for (const object of this.objects) {
      for (const key of NUMBER_KEYS) object[key] = key === "angle_deg" ? normalizedDeg(object[key]) : rounded(object[key]);
    }
    if (JSON.stringify(before) !== JSON.stringify(this.objects)) {
      this.history.push(before);
      this.isSaved = false;
    }
    this.show();
  }

  // A distinctiveness is that of one place and shape: an object that changed has none.
  forgetDistinctiveness(before) {
    this.objects.forEach((object, index) => {
      if (NUMBER_KEYS.some((key) => before[index]?.[key] !== object[key])) delete object.distinctiveness;
    });
  }

  undo() {
    if (!this.history.length || this.gesture) return;
    this.objects = this.history.pop();
    this.selected = null;
    this.isSaved = false;
    this.say("Undone.");
    this.show();
  }

  // "name" where it is free, else the first free "object N".
  freeName(name = "") {
    const taken = new Set(this.objects.map((object) => object.name));
    let number = this.objects.length + 1;
    while (!name || taken.has(name)) name = `object ${number++}`;
    return name;
  }

  add([x_m, y_m], size_x_m, size_y_m) {
    const object = { name: this.freeName(), x_m, y_m, size_x_m, size_y_m, angle_deg: 0 };
    this.objects.push(object);
    this.selected = this.objects.length - 1;
    return object;
  }

  remove(index) {
    const before = this.snapshot(), [object] = this.objects.splice(index, 1);
    this.selected = null;
    this.say(`Deleted "${object.name}". Ctrl+Z brings it back.`);
    this.commit(before);
    this.part("svg").focus({ preventScroll: true });
  }

  // A side within the limits; says so when it is cut.
  clampedSize(size_m) {
    if (size_m > this.maxSizeM) this.say(`A side is ${this.maxSizeM} m long at most: the rectangle was made smaller.`, true);
    return Math.min(Math.max(size_m, MIN_SIZE_M), this.maxSizeM);
  }

  edit(index, key, text) {
    const before = this.snapshot(), object = this.objects[index];
    this.say("");
    if (key === "name") {
      this.rename(object, text.replace(/[\p{Cc}\p{Zl}\p{Zp}]/gu, " ").trim());
    } else if (text === "" || !(Math.abs(Number(text)) <= MAX_VALUE)) {
      this.say(`${key} of "${object.name}" must be a number of at most ${MAX_VALUE}.`, true);
    } else if (key.startsWith("size") && Number(text) <= 0) {
      this.say(`${key} of "${object.name}" must be above 0.`, true);
    } else if (rounded(Number(text)) !== object[key]) {
      object[key] = key.startsWith("size") ? this.clampedSize(Number(text)) : Number(text);
    }
    this.forgetDistinctiveness(before);
    this.commit(before);
  }

  rename(object, name) {
    if (name === object.name) return;
    if (this.objects.some((other) => other !== object && other.name === name)) {
      this.say(`There is an object "${name}" already; this one stays "${object.name}".`, true);
      return;
    }
    object.name = name || this.freeName();
  }

  key(event) {
    const isField = event.target.matches("input:not([type=file])");
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !event.shiftKey) {
      if (this.list.isTyping(event.target)) return;  // the browser undoes the typing
      event.preventDefault();
      this.undo();
    } else if (event.key === "Delete" && !isField && this.selected !== null && !this.gesture) {
      event.preventDefault();
      this.remove(this.selected);
    } else if (event.key === "Escape" && this.gesture) {
      this.endGesture(true);
    }
  }

  bindButtons(files) {
    const on = (selector, action) => this.part(selector).addEventListener("click", action);
    on(".undo", () => this.undo());
    on(".download", () => this.download());
    on(".whole", () => { this.map.showAll(); this.show(); });
    on(".new", () => {
      const before = this.snapshot();
      this.add(this.map.centre(), NEW_SIZE_M, NEW_SIZE_M);
      this.commit(before);
      this.list.rows[this.selected].inputs.name.focus();
    });
    on(".pan", () => {
      this.panning = !this.panning;
      this.part(".pan").setAttribute("aria-pressed", this.panning);
      this.part("svg").classList.toggle("panning", this.panning);
    });
    for (const { title, name, text } of files) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = title;
      button.addEventListener("click", () => this.open(text, name));
      this.part(".files").append(button);
    }
    this.root.closest("details")?.addEventListener("toggle", () => this.show());  // pixels have a size only when it is open
    addEventListener("resize", () => this.map.draw(this.objects, this.selected));
  }

  bindFiles() {
    const input = this.part("input[type=file]");
    input.addEventListener("change", () => { this.openFile(input.files[0]); input.value = ""; });
    this.root.addEventListener("dragover", (event) => event.preventDefault());
    this.root.addEventListener("drop", (event) => {
      event.preventDefault();
      this.openFile(event.dataTransfer.files[0]);
    });
  }

  openFile(file) {
    if (!file) return;
    if (file.size > MAX_FILE_BYTES) {
      this.say(`${file.name} is larger than ${MAX_FILE_BYTES / 1e6} MB: no file of objects. The objects here are as before.`, true);
      return;
    }
    file.text().then((text) => this.open(text, file.name),
                     (error) => this.say(`${file.name}: ${error.message}. The objects here are as before.`, true));
  }

  open(text, name) {
    const before = this.snapshot();
    try {
      this.objects = objectsFromText(text);
    } catch (error) {
      this.say(`${name}: ${error.message}. The objects here are as before.`, true);
      return;
    }
    this.selected = null;
    const cut = this.objects.filter((object) => Math.max(object.size_x_m, object.size_y_m) > this.maxSizeM);
    for (const object of cut) {
      for (const key of ["size_x_m", "size_y_m"]) object[key] = Math.min(object[key], this.maxSizeM);
    }
    const names = cut.map((object) => `"${object.name}"`).join(", ");
    const back = before.length ? " Ctrl+Z brings back those before." : "";
    const smaller = cut.length ? ` A side is ${this.maxSizeM} m long at most: made smaller: ${names}.` : "";
    this.say(`Opened ${name}: ${this.objects.length} objects.${back}${smaller}`, cut.length > 0);
    this.commit(before);
  }

  download() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([objectsToText(this.objects)], { type: "application/yaml" }));
    link.download = "objects.yaml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    this.isSaved = true;
    this.say(`objects.yaml has ${this.objects.length} objects. The command above gives them to the next make.`);
  }
}
