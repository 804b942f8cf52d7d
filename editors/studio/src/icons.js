// Buttons with a picture; their names are for screen readers and for whoever rests the pointer on them.

import { element } from "./dom.js";

export function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg"), use = document.createElementNS(svg.namespaceURI, "use");
  use.setAttribute("href", `#icon-${name}`);
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  svg.append(use);
  return svg;
}

export function iconButton(name, label, onclick, attributes = {}) {
  return element("button", { class: "quiet", "aria-label": label, title: label, onclick, ...attributes }, icon(name));
}
