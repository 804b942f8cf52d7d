// Makes elements; texts stay texts.

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key === "class") made.className = value;
    else if (value !== undefined && value !== null && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

// Returns the parts of a text; words between backticks are code.
export function coded(text) {
  const parts = text.split(/`([^`\n]+)`/);
  return parts.map((part, number) => (number % 2 ? element("code", {}, part) : part)).filter((part) => part !== "");
}

export const find = (name) => document.querySelector(`[data-part="${name}"]`);

export function table(rows, header) {
  const body = element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, cell)))));
  return element("table", {}, header ? element("thead", {}, element("tr", {}, ...header.map((text) => element("th", {}, text)))) : null, body);
}
