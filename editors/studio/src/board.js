// The board: draws the moment that is shown, and tells which cell somebody points at. `board.js` of sjdsl draws on the canvas.

/* global paintBoard, changeCells */

const SIDE = 720, SMALLEST = 48, LARGEST = 192; // pixels: what a board is made for, and how large a cell can be drawn
const MOST = 1000; // pictures that are kept

export class Board {
  // place: around the canvas, which the board fills as far as its height goes; onCell: called with row and column of a cell that was clicked or
  // reached by keys; onPut: with agent, row, column.
  // onPaint: with row and column of each cell that the pointer goes over, while `painting`.
  constructor(canvas, place, { onCell, onPut, onPaint }) {
    Object.assign(this, { canvas, place, onCell, onPut, onPaint });
    this.map = null;
    this.painting = false;
    this.drawn = Promise.resolve();
    let grabbed = null, painted = null;
    const stroke = (event) => {
      const cell = this.cellAt(event);
      if (!cell || String(cell) === painted) return;
      painted = String(cell);
      this.onPaint(...cell);
    };
    canvas.addEventListener("pointerdown", (event) => {
      grabbed = this.agentAt(this.cellAt(event));
      painted = null;
      if (this.painting) { canvas.setPointerCapture(event.pointerId); stroke(event); }
    });
    canvas.addEventListener("pointermove", (event) => { if (this.painting && event.buttons) stroke(event); });
    canvas.addEventListener("pointerup", (event) => {
      const cell = this.cellAt(event);
      if (!cell || this.painting) return;
      const at = grabbed === null ? null : this.agents[grabbed];
      if (at && (at[0] !== cell[0] || at[1] !== cell[1])) this.onPut(grabbed, ...cell);
      else this.onCell(...cell);
      grabbed = null;
    });
    new ResizeObserver(() => this.paint()).observe(place);
    this.loaded = new Map(); // pictures by address and size, of this game and those before it
  }

  // Another game, or the same one with other pictures.
  begin(game) {
    const size = Math.min(LARGEST, Math.max(SMALLEST, Math.round(SIDE / Math.max(game.height, game.width)))) * Math.ceil(devicePixelRatio || 1);
    this.map = { height: game.height, width: game.width, size };
    if (this.loaded.size > MOST) this.loaded.clear();
    if (this.chosen && (this.chosen[0] >= game.height || this.chosen[1] >= game.width)) this.chosen = null;
    this.images = [];
    this.cells = new Uint16Array(game.height * game.width);
    this.count = game.agents;
  }

  // Draws a moment as soon as the ones before it are drawn; pictures: those that are new.
  show(scene, pictures) {
    const { map } = this;
    this.drawn = this.drawn.then(async () => {
      const images = await Promise.all(pictures.map((url) => this.picture(url, map.size)));
      if (map !== this.map) return;
      this.images.push(...images);
      changeCells(this.cells, scene.cells);
      this.scene = scene;
      this.agents = scene.places;
      this.paint();
    });
    return this.drawn;
  }

  picture(url, size) {
    const key = `${size} ${url}`;
    if (!this.loaded.has(key)) this.loaded.set(key, pictureOf(url, size));
    return this.loaded.get(key);
  }

  paint() {
    if (!this.map || !this.scene) return;
    const room = getComputedStyle(this.place), height = parseFloat(room.getPropertyValue("--most")) / 100 * innerHeight;
    paintBoard(this.canvas, this.map, this.images, this.cells, this.scene, Math.min(this.place.clientWidth, (height * this.map.width) / this.map.height));
    if (this.chosen) this.outline(...this.chosen);
  }

  choose(row, col) {
    this.chosen = row === undefined ? null : [row, col];
    this.paint();
  }

  // Chooses the cell beside the chosen one; the first time, that of the first agent, or the middle.
  move(rows, cols) {
    if (!this.map) return;
    const from = this.chosen ?? this.agents?.find(Boolean) ?? [this.map.height >> 1, this.map.width >> 1];
    const [row, col] = this.chosen ? [from[0] + rows, from[1] + cols] : from;
    this.onCell(Math.min(Math.max(row, 0), this.map.height - 1), Math.min(Math.max(col, 0), this.map.width - 1));
  }

  outline(row, col) {
    const pen = this.canvas.getContext("2d"), cell = this.canvas.width / this.map.width;
    pen.strokeStyle = "#ff00aa";
    pen.lineWidth = Math.max(1, cell / 12);
    pen.strokeRect(col * cell, row * cell, cell, cell);
  }

  // Draws what an agent sees once the moment is drawn. window: row and column of each cell, by rows, null for what it does not see;
  // heading: of the agent, in quarter turns; it points up.
  async paintWindow(canvas, window, heading) {
    await this.drawn;
    if (!this.map) return;
    const side = this.map.size, pen = canvas.getContext("2d");
    canvas.width = side * window[0].length;
    canvas.height = side * window.length;
    const put = (picture, row, col) => {
      pen.save();
      pen.translate((col + 0.5) * side, (row + 0.5) * side);
      pen.rotate((-heading * Math.PI) / 2);
      pen.drawImage(this.images[picture], -side / 2, -side / 2, side, side);
      pen.restore();
    };
    const places = window.flatMap((cells, row) => cells.flatMap((cell, col) => (cell ? [[cell, row, col]] : [])));
    for (const [[row, col], down, right] of places) put(this.cells[row * this.map.width + col], down, right);
    for (const [picture, row, col] of this.scene.figures) {
      for (const [cell, down, right] of places) if (cell[0] === row && cell[1] === col) put(picture, down, right);
    }
  }

  cellAt(event) {
    if (!this.map) return null;
    const box = this.canvas.getBoundingClientRect();
    const row = Math.floor(((event.clientY - box.top) / box.height) * this.map.height);
    const col = Math.floor(((event.clientX - box.left) / box.width) * this.map.width);
    return row >= 0 && row < this.map.height && col >= 0 && col < this.map.width ? [row, col] : null;
  }

  agentAt(cell) {
    const found = cell && this.agents ? this.agents.findIndex((at) => at && at[0] === cell[0] && at[1] === cell[1]) : -1;
    return found < 0 ? null : found;
  }
}

// Resolves to a picture of so many pixels a side: `loadPicture` of board.js makes one as large as its file says.
async function pictureOf(url, size) {
  const image = new Image(), picture = document.createElement("canvas");
  image.src = url;
  await image.decode();
  picture.width = picture.height = size;
  picture.getContext("2d").drawImage(image, 0, 0, size, size);
  return picture;
}
