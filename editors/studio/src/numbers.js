// The numbers of a game: a slider, field or menu for each, and for each entry of a table. All act at once.

import { element } from "./dom.js";

const short = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : value);

// Fills a place. set: called with the name of a number and its new value; of a table with the one entry, { soft: { hard: 3 } }.
export function showNumbers(place, numbers, set) {
  if (place.contains(document.activeElement)) return; // somebody is just setting one
  place.replaceChildren(...numbers.map((number) => {
    if (number.entries.length === 1 && !number.entries[0][0].length) return single(number, set);
    const body = number.entries[0]?.[0].length === 2 ? matrix(number, set) : list(number, set);
    const more = number.left_out ? element("p", { class: "hint" }, `and ${number.left_out} more entries`) : null;
    return element("fieldset", {}, element("legend", {}, titleOf(number)), body, more);
  }));
}

const titleOf = (number) => (number.unit ? `${number.name} (${number.unit})` : number.name);

function single(number, set) {
  const [, value] = number.entries[0];
  const shown = element("output", {}, number.words.length ? "" : short(value));
  const input = field(number, value, number.name, (chosen) => { shown.textContent = number.words.length ? "" : short(chosen); set(number.name, chosen); });
  return element("label", {}, element("span", {}, titleOf(number)), input, shown);
}

function list(number, set) {
  return element("div", {}, ...number.entries.map(([names, value]) => {
    const shown = element("output", {}, number.words.length ? "" : short(value));
    const input = field(number, value, `${number.name} ${names.join(" ")}`, (chosen) => {
      shown.textContent = number.words.length ? "" : short(chosen);
      set(number.name, entryOf(names, chosen));
    });
    return element("label", {}, element("span", {}, names.join(", ")), input, shown);
  }));
}

// A table of two levels stands as one: the first downwards, the second to the right.
function matrix(number, set) {
  const rows = [...new Set(number.entries.map(([names]) => names[0]))], columns = [...new Set(number.entries.map(([names]) => names[1]))];
  const values = new Map(number.entries.map(([names, value]) => [names.join(" "), value]));
  const cell = (row, column) => values.has(`${row} ${column}`)
    ? field(number, values.get(`${row} ${column}`), `${number.name} ${row} ${column}`, (chosen) => set(number.name, entryOf([row, column], chosen)), false)
    : "";
  return element("table", { class: "matrix" },
    element("thead", {}, element("tr", {}, element("th", {}), ...columns.map((column) => element("th", {}, column)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, element("th", {}, row), ...columns.map((column) => element("td", {}, cell(row, column)))))));
}

function entryOf(names, value) {
  return names.reduceRight((inner, name) => ({ [name]: inner }), value);
}

// A slider where both limits are known, else a field; a menu for words. A field that holds no number changes nothing.
function field(number, value, label, changed, slider = true) {
  if (number.words.length) {
    const menu = element("select", { "aria-label": label, onchange: () => changed(menu.value) });
    menu.append(...number.words.map((word) => new Option(word, word, false, word === value)));
    return menu;
  }
  const ranged = number.low !== null && number.high !== null;
  const step = number.whole ? 1 : ranged && slider ? (number.high - number.low) / 100 || "any" : "any";
  const input = element("input", {
    type: ranged && slider ? "range" : "number", min: number.low, max: number.high, step, value, "aria-label": label,
    oninput: () => { if (input.value !== "") changed(Number(input.value)); },
  });
  return input;
}

// Returns the numbers somebody has set, with one more set: entries of a table beside those before.
export function withNumber(params, name, value) {
  return { ...params, [name]: merged(params[name], value) };
}

function merged(before, value) {
  if (typeof value !== "object" || value === null) return value;
  const known = typeof before === "object" && before !== null ? before : {};
  return { ...known, ...Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, merged(known[key], inner)])) };
}
