// Draws the returns of all agents as lines, each with its agent's number, and a line at the moment that is shown.
"use strict";

const PLOT = { width: 420, height: 150, left: 44, right: 20, top: 24, bottom: 32 };
const APART = 9; // least distance of two numbers at the ends of lines
const SVG = "http://www.w3.org/2000/svg";

function svgElement(name, attributes, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

// Returns a function that moves the line to a moment. place: an <svg>; shown: called with the moment somebody clicks on.
function plotReturns(place, data, shown) {
  const { width, height, left, right, top, bottom } = PLOT;
  const returns = data.moments.map((moment) => moment.returns);
  const all = returns.flat().concat(0);
  const [low, most] = extremes(all);
  const high = most > low ? most : low + 1;
  const last = Math.max(1, returns.length - 1);
  const x = (number) => left + (number / last) * (width - left - right);
  const y = (value) => top + ((high - value) / (high - low)) * (height - top - bottom);
  place.setAttribute("viewBox", `0 0 ${width} ${height}`);
  for (const value of low === 0 || high === 0 ? [low, high] : [low, 0, high]) {
    place.append(svgElement("line", { x1: left, x2: width - right, y1: y(value), y2: y(value), class: "grid" }));
    place.append(svgElement("text", { x: left - 4, y: y(value) + 3, "text-anchor": "end" }, Number(value.toPrecision(3))));
  }
  data.agents.forEach((colour, agent) => {
    const points = returns.map((row, number) => `${x(number).toFixed(1)},${y(row[agent]).toFixed(1)}`).join(" ");
    place.append(svgElement("polyline", { points, stroke: colour, fill: "none", class: "line" }));
  });
  const ends = returns.at(-1).map((value, agent) => [y(value), agent]).sort((a, b) => a[0] - b[0]);
  let above = -Infinity;
  for (const [end, agent] of ends) {
    if (end - above < APART) continue;
    place.append(svgElement("text", { x: width - right + 4, y: end + 3 }, agent));
    above = end;
  }
  place.append(svgElement("text", { x: left, y: 12, class: "title" }, "Return of each agent so far"));
  for (const number of [0, returns.length - 1]) {
    place.append(svgElement("text", { x: x(number), y: height - bottom + 13, "text-anchor": "middle" }, data.moments[number].step));
  }
  place.append(svgElement("text", { x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, "step"));
  const cursor = svgElement("line", { y1: top, y2: height - bottom, class: "cursor" });
  place.append(cursor);
  place.addEventListener("click", (event) => {
    const at = (event.clientX - place.getBoundingClientRect().left) * (width / place.getBoundingClientRect().width);
    shown(Math.min(returns.length - 1, Math.max(0, Math.round(((at - left) / (width - left - right)) * last))));
  });
  return (number) => {
    cursor.setAttribute("x1", x(number));
    cursor.setAttribute("x2", x(number));
  };
}

// Returns the smallest and the largest of many numbers.
function extremes(numbers) {
  return numbers.reduce(([low, high], number) => [Math.min(low, number), Math.max(high, number)], [Infinity, -Infinity]);
}
