// Curves of the episode so far: the returns of the agents, and under them each metric of the game.

import { element, find } from "./dom.js";

const PAD = { left: 40, right: 8, top: 6, bottom: 4 }; // pixels

export class Curves {
  // ask: for the whole episode, { returns, metrics }; choose: called with the moment that somebody clicks on.
  constructor({ ask, choose }) {
    Object.assign(this, { ask, choose });
    this.returns = []; // of each moment; where nobody has seen it, a hole
    this.metrics = [];
    this.at = 0;
    find("returns").addEventListener("click", (event) => this.clicked(event));
    new ResizeObserver(() => this.paint()).observe(find("curves"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.soon());
  }

  // Another game or other rules. metrics: each [name, whether its counts add up].
  begin({ metrics }) {
    this.returns = [];
    this.metrics = [];
    const signature = JSON.stringify(metrics);
    if (signature === this.signature) return;
    Object.assign(this, { signature, names: metrics });
    this.figures = metrics.map(([name, adds]) => {
      const canvas = element("canvas", { "aria-hidden": "true" }), value = element("b", {});
      canvas.addEventListener("click", (event) => this.clicked(event));
      return { canvas, value, made: element("figure", {}, element("figcaption", { title: adds ? `${name}, of all agents, so far` : `${name} in each step` }, element("span", {}, name), value), canvas) };
    });
    find("metrics").replaceChildren(...this.figures.map(({ made }) => made));
  }

  // A moment that is shown: what came after a step that somebody has taken from an earlier one is gone.
  note({ at, moments, scene, metrics, colours }) {
    this.returns.length = Math.min(this.returns.length, moments);
    this.metrics.length = this.returns.length;
    this.returns[at] = scene.returns;
    this.metrics[at] = metrics;
    Object.assign(this, { at, moments, colours });
    this.soon();
  }

  // Fetches what nobody has seen here: moments before an edit, or of a counterexample.
  async fill() {
    const known = this.returns;
    if (known.length === this.moments && !Array.from(known).includes(undefined)) return;
    const all = await this.ask();
    if (all.refused || this.returns !== known) return;
    this.returns = all.returns;
    this.metrics = all.metrics;
    this.soon();
  }

  // Paints after the next frame, which has the board.
  soon() {
    this.frame ??= requestAnimationFrame(() => setTimeout(() => { this.frame = null; this.paint(); }));
  }

  paint() {
    if (!this.colours || !find("curves").clientWidth) return;
    const agents = this.colours.length, style = getComputedStyle(document.body);
    const [ink, muted, line] = ["--accent", "--muted", "--line"].map((name) => style.getPropertyValue(name));
    const canvases = [find("returns"), ...this.figures.map(({ canvas }) => canvas)];
    const sizes = new Map(canvases.map((canvas) => [canvas, [canvas.clientWidth, canvas.clientHeight]])); // all before any changes: each change would ask for a new layout
    const draw = (canvas, lines, colours) => this.draw(canvas, sizes.get(canvas), { muted, line }, lines, colours);
    draw(find("returns"), Array.from({ length: agents }, (_, agent) => Array.from(this.returns, (row) => row?.[agent])), this.colours);
    find("returns").setAttribute("aria-label", `Returns by step. ${(this.returns[this.at] ?? []).map((value, agent) => `Agent ${agent}: ${short(value)}`).join(", ")}`);
    this.names.forEach(([, adds], number) => {
      let sum = 0;
      const values = Array.from(this.metrics, (row) => (row === undefined || (!row.length && !adds) ? undefined : adds ? (sum += row[number] ?? 0) : row[number]));
      this.figures[number].value.textContent = short(values[this.at] ?? 0);
      draw(this.figures[number].canvas, [values], [ink]);
    });
  }

  // Draws lines from the first to the last moment, and the moment that is shown. Values start at 0 where none is below it.
  draw(canvas, [width, height], shades, lines, colours) {
    const density = devicePixelRatio || 1;
    Object.assign(canvas, { width: width * density, height: height * density });
    const pen = canvas.getContext("2d"), last = Math.max(1, this.moments - 1);
    pen.scale(density, density);
    let low = 0, high = 0;
    for (const line of lines) for (const value of line) if (value !== undefined) { low = Math.min(low, value); high = Math.max(high, value); }
    if (high === low) high = low + 1;
    const x = (moment) => PAD.left + (moment / last) * (width - PAD.left - PAD.right);
    const y = (value) => PAD.top + ((high - value) / (high - low)) * (height - PAD.top - PAD.bottom);
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of new Set([low, 0, high])) {
      pen.fillStyle = shades.muted;
      pen.fillText(short(value), PAD.left - 6, y(value));
      pen.strokeStyle = shades.line;
      stroke(pen, [[PAD.left, y(value)], [width - PAD.right, y(value)]]);
    }
    pen.lineJoin = "round";
    const every = Math.ceil(this.moments / Math.max(1, 2 * width)); // more points than that nobody can see
    lines.forEach((line, number) => {
      const points = line.flatMap((value, moment) => (value !== undefined && (moment % every === 0 || moment === last) ? [[x(moment), y(value)]] : []));
      pen.strokeStyle = colours[number];
      pen.lineWidth = 1.75;
      stroke(pen, points);
    });
    pen.lineWidth = 1;
    pen.strokeStyle = shades.muted;
    stroke(pen, [[x(this.at), PAD.top], [x(this.at), height - PAD.bottom]]);
  }

  clicked(event) {
    const box = event.currentTarget.getBoundingClientRect(), last = this.moments - 1;
    const share = (event.clientX - box.left - PAD.left) / (box.width - PAD.left - PAD.right);
    this.choose(Math.min(last, Math.max(0, Math.round(share * last))));
  }
}

function stroke(pen, points) {
  pen.beginPath();
  points.forEach(([x, y], number) => (number ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.stroke();
}

export const short = (value) => (typeof value === "number" ? String(Number(value.toPrecision(4))).replace("-", "−") : value);
