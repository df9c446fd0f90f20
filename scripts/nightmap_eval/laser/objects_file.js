// SPDX-License-Identifier: Apache-2.0
// objects.yaml, the file of objects: read and written by the report's page. The reader takes this flat format alone, not YAML.
// Angles are in degrees, counter-clockwise from the map's x axis; lengths in metres, in the map frame.
"use strict";

const FORMAT = "nightmap objects", VERSION = 1;
const NUMBER_KEYS = ["x_m", "y_m", "size_x_m", "size_y_m", "angle_deg"];
const OBJECT_KEYS = ["name", ...NUMBER_KEYS, "distinctiveness"];
const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$/;
const KEY_VALUE = /^(\w+)[ ]*:(?:[ ]+(.*))?$/;
const EMPTY_LIST = "[]";
const MAX_VALUE = 1e6;  // of lengths and angles; beyond it is no map

function rounded(value) {
  return Math.round(value * 1000) / 1000 + 0;  // + 0: never -0
}

// Within (-180, 180].
function normalizedDeg(angleDeg) {
  const turn = rounded(angleDeg) - 360 * Math.ceil((rounded(angleDeg) - 180) / 360);
  return rounded(turn);
}

function objectsToText(objects) {
  const lines = [`format: ${FORMAT}`, `version: ${VERSION}`, objects.length ? "objects:" : `objects: ${EMPTY_LIST}`];
  for (const object of objects) {
    lines.push(`  - name: "${object.name.replace(/[\\"]/g, "\\$&")}"`);
    for (const key of OBJECT_KEYS.slice(1)) {
      if (object[key] !== undefined) lines.push(`    ${key}: ${object[key].toFixed(3)}`);
    }
  }
  return lines.join("\n") + "\n";
}

// Throws an Error that names the line or key.
function objectsFromText(text) {
  const head = {}, items = [];
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/);
  lines.forEach((line, index) => {
    const where = `line ${index + 1}`;
    if (/^\s*(#.*)?$/.test(line)) return;
    if (/\p{Cc}/u.test(line)) throw new Error(`${where}: a tab or another control character; YAML is indented by spaces`);
    const [, indent, dash, content] = /^( *)(- +)?(.*)$/.exec(line);
    const found = KEY_VALUE.exec(content);
    if (!found) throw new Error(`${where}: neither "key: value" nor a comment: ${content.slice(0, 40)}`);
    const [key, value] = [found[1], valueOf(found[2] ?? "", where)];
    if (!indent && !dash) {
      addOnce(head, key, value, where, ["format", "version", "objects"]);
    } else {
      addToItems(items, head, indent.length, dash, key, value, where);
    }
  });
  checkHead(head, items);
  const names = new Set();
  return items.map((item) => objectOf(item, names));
}

// The text of a value without quotes and comment.
function valueOf(text, where) {
  const quoted = /^(?:"((?:[^"\\]|\\.)*)"|'((?:[^']|'')*)')\s*(?:#.*)?$/.exec(text);
  if (quoted) return quoted[1] !== undefined ? unescaped(quoted[1], where) : quoted[2].replace(/''/g, "'");
  if (/^["']/.test(text)) throw new Error(`${where}: the quotation marks do not close`);
  return text.replace(/(^|\s)#.*$/, "").trim();
}

function unescaped(text, where) {
  return text.replace(/\\(.)/g, (all, letter) => {
    if (!'\\"'.includes(letter)) throw new Error(`${where}: ${all} is no escape of this format; \\" and \\\\ are`);
    return letter;
  });
}

function addOnce(table, key, value, where, known) {
  if (!known.includes(key)) throw new Error(`${where}: unknown key "${key}"; known keys: ${known.join(", ")}`);
  if (Object.hasOwn(table, key)) throw new Error(`${where}: "${key}" is given twice`);
  table[key] = value;
}

function addToItems(items, head, indent, dash, key, value, where) {
  if (head.objects === undefined) throw new Error(`${where}: "${key}" is indented, and no line "objects:" stands before it`);
  const keyIndent = indent + (dash ? dash.length : 0);
  if (dash) {
    if (items.length && items[0].dashIndent !== indent) {
      throw new Error(`${where}: the dash is indented by ${indent} spaces, that of the first object by ${items[0].dashIndent}`);
    }
    items.push({ where, dashIndent: indent, keyIndent, table: {} });
  }
  const item = items.at(-1);
  if (!item) throw new Error(`${where}: an object begins with a dash, as in "  - name: ..."`);
  if (keyIndent !== item.keyIndent) {
    throw new Error(`${where}: "${key}" is indented by ${keyIndent} spaces, the object's first key by ${item.keyIndent}`);
  }
  addOnce(item.table, key, value, where, OBJECT_KEYS);
}

function checkHead(head, items) {
  for (const key of ["format", "version", "objects"]) {
    if (head[key] === undefined) throw new Error(`no key "${key}"`);
  }
  if (head.format !== FORMAT) throw new Error(`format is "${head.format.slice(0, 40)}", not "${FORMAT}"`);
  if (head.version !== String(VERSION)) {
    throw new Error(`version is "${head.version.slice(0, 40)}"; this page reads version ${VERSION}`);
  }
  if (head.objects !== "" && (head.objects !== EMPTY_LIST || items.length)) {
    throw new Error('the objects are a list below "objects:", an item per object');
  }
}

// names: those of the objects before, to which it adds its own.
function objectOf({ where, table }, names) {
  const object = { name: table.name };
  const called = table.name ? `object "${table.name}"` : "the object";
  const missing = OBJECT_KEYS.find((key) => table[key] === undefined && key !== "distinctiveness");
  if (missing) throw new Error(`${where}: ${called} has no key "${missing}"`);
  if (!object.name) throw new Error(`${where}: the object's name is empty`);
  if (names.has(object.name)) throw new Error(`${where}: a second ${called}; each name stands once`);
  names.add(object.name);
  for (const key of OBJECT_KEYS.slice(1)) {
    if (table[key] === undefined) continue;
    const value = Number(table[key]);
    if (!NUMBER.test(table[key]) || !Number.isFinite(value)) {
      throw new Error(`${where}: ${key} of ${called} is "${table[key].slice(0, 40)}", no finite number`);
    }
    if (Math.abs(value) > MAX_VALUE) throw new Error(`${where}: ${key} of ${called} is ${value}, beyond ${MAX_VALUE}`);
    object[key] = key === "angle_deg" ? normalizedDeg(value) : rounded(value);
    if (key.startsWith("size") && object[key] <= 0) {
      throw new Error(`${where}: ${key} of ${called} is ${value}; a size is 0.001 at least`);
    }
    if (key === "distinctiveness" && !(value >= 0 && value <= 1)) {
      throw new Error(`${where}: ${key} of ${called} is ${value}, not within 0 and 1`);
    }
  }
  return object;
}
