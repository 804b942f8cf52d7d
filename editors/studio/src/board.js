// The board: draws the moment that is shown, and tells which cell somebody points at. `board.js` of sjdsl draws on the canvas.

/* global paintBoard, loadPicture, changeCells */

export class Board {
  // place: around the canvas; onCell: called with row and column of a cell that was clicked; onPut: with agent, row, column.
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
  }

  // Another game, or the same one with other pictures.
  begin(game) {
    this.map = { height: game.height, width: game.width, size: 48, marks: game.marks };
    this.images = [];
    this.cells = new Uint16Array(game.height * game.width);
    this.count = game.agents;
  }

  // Draws a moment as soon as the ones before it are drawn; pictures: those that are new.
  show(scene, pictures) {
    const { map } = this;
    this.drawn = this.drawn.then(async () => {
      const images = await Promise.all(pictures.map(loadPicture));
      if (map !== this.map) return;
      this.images.push(...images);
      changeCells(this.cells, scene.cells);
      this.scene = scene;
      this.agents = scene.places;
      this.paint();
    });
    return this.drawn;
  }

  paint() {
    if (!this.map || !this.scene) return;
    paintBoard(this.canvas, this.map, this.images, this.cells, this.scene, this.place.clientWidth);
    if (this.chosen) this.outline(...this.chosen);
  }

  choose(row, col) {
    this.chosen = row === undefined ? null : [row, col];
    this.paint();
  }

  outline(row, col) {
    const pen = this.canvas.getContext("2d"), cell = this.canvas.width / this.map.width;
    pen.strokeStyle = "#ff00aa";
    pen.lineWidth = Math.max(1, cell / 12);
    pen.strokeRect(col * cell, row * cell, cell, cell);
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
