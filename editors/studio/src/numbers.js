// The numbers of a game: a slider, field or menu for each, and for each entry of a table. All act at once.

import { element } from "./dom.js";
import { iconButton } from "./icons.js";

const short = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : value);
const isTable = ({ entries }) => entries.length !== 1 || entries[0][0].length > 0;

// Fills a place. set: called with the name of a number, the keys of one entry, its new value, and whether that is what the text has; resolves to
// whether it was taken. write: called with the name of a number, the keys of one entry, and the value as it is to stand in the text.
export function showNumbers(place, numbers, { set, write }) {
  const form = JSON.stringify(numbers.map(({ entries, ...number }) => [number, entries.map(([names]) => names)]));
  if (place.form !== form) {
    place.form = form;
    place.fields = new Map();
    const act = { set, write, fields: place.fields };
    place.replaceChildren(...numbers.map((number) => {
      if (!isTable(number)) return row(number, number.entries[0], titleOf(number), act);
      const body = number.entries[0][0].length === 2 ? matrix(number, act) : element("div", {}, ...number.entries.map((entry) => row(number, entry, entry[0].join(", "), act)));
      const more = number.left_out ? element("p", { class: "hint" }, `and ${number.left_out} more entries`) : null;
      return element("fieldset", {}, element("legend", {}, titleOf(number)), body, more);
    }));
  }
  for (const { name, entries } of numbers) for (const [names, value, written] of entries) place.fields.get([name, ...names].join(" ")).show(value, written);
}

const titleOf = (number) => (number.unit ? `${number.name} (${number.unit})` : number.name);

function row(number, entry, title, act) {
  const { input, shown, tools } = field(number, entry, act);
  return element("div", { class: "number" }, element("label", { for: input.id }, title), input, shown, tools);
}

// A table of two levels stands as one: the first downwards, the second to the right.
function matrix(number, act) {
  const rows = [...new Set(number.entries.map(([names]) => names[0]))], columns = [...new Set(number.entries.map(([names]) => names[1]))];
  const entries = new Map(number.entries.map((entry) => [entry[0].join(" "), entry]));
  const cell = (row, column) => {
    const entry = entries.get(`${row} ${column}`);
    if (!entry) return "";
    const { input, tools } = field(number, entry, act, false);
    return element("div", { class: "entry" }, input, tools);
  };
  return element("table", { class: "matrix" },
    element("thead", {}, element("tr", {}, element("td", {}), ...columns.map((column) => element("th", { scope: "col" }, column)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, element("th", { scope: "row" }, row), ...columns.map((column) => element("td", {}, cell(row, column)))))));
}

// A slider where both limits are known, else a field; a menu for words. A field that holds no number changes nothing, and a value that the game
// refuses is put back.
function field(number, [names], { set, write, fields }, slider = true) {
  const label = [number.name, ...names].join(" "), id = `number ${label}`.replaceAll(" ", "-");
  const isWord = number.words.length > 0, ranged = number.low !== null && number.high !== null;
  const shown = element("output", { for: id });
  let now = null, written = null;
  const choose = async (value) => {
    const before = now;
    show(value, written);
    if (!(await set(number.name, names, value, value === written)) && now === value) { show(before, written); input.value = before; }
  };
  const input = isWord ? element("select", { id, "aria-label": label, onchange: () => choose(input.value) }) : element("input", {
    id, type: ranged && slider ? "range" : "number", min: number.low, max: number.high, "aria-label": label,
    step: number.whole ? 1 : ranged && slider ? (number.high - number.low) / 100 || "any" : "any",
    oninput: () => { if (input.value !== "") choose(Number(input.value)); },
  });
  if (isWord) input.append(...number.words.map((word) => new Option(word)));
  const back = iconButton("reset", `Reset ${label}`, () => { choose(written); input.value = written; });
  const put = iconButton("write", `Write ${label} into the text`, () => write(number.name, names, textOf(now)));
  const tools = element("span", { class: "tools" }, back, put);
  const show = (value, inText) => {
    [now, written] = [value, inText];
    if (document.activeElement !== input) input.value = value;
    shown.textContent = isWord || input.type === "number" ? "" : short(value);
    tools.classList.toggle("idle", value === inText);
    back.disabled = put.disabled = value === inText;
    back.title = `Back to ${short(inText)}, as the text has it`;
  };
  fields.set(label, { show });
  return { input, shown, tools };
}

// A number as the language writes it: without an exponent.
function textOf(value) {
  if (typeof value !== "number") return value;
  const text = String(Number(value.toPrecision(7)));
  return text.includes("e") ? value.toFixed(15).replace(/\.?0+$/, "") : text;
}

// Returns the value of one entry as the table it is in: { soft: { hard: 3 } }.
export const entryOf = (names, value) => names.reduceRight((inner, name) => ({ [name]: inner }), value);

// Returns the numbers somebody has set, with one more set: entries of a table beside those before.
export function withNumber(params, name, value) {
  return { ...params, [name]: merged(params[name], value) };
}

// Returns them without one number, or without one entry of it.
export function withoutNumber(params, name, names) {
  const { [name]: own, ...rest } = params;
  if (own === undefined || !names.length) return rest;
  const left = withoutNumber(own, names[0], names.slice(1));
  return Object.keys(left).length ? { ...rest, [name]: left } : rest;
}

function merged(before, value) {
  if (typeof value !== "object" || value === null) return value;
  const known = typeof before === "object" && before !== null ? before : {};
  return { ...known, ...Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, merged(known[key], inner)])) };
}
