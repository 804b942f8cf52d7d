// Draws the board of an episode on a canvas: cells, marks over them, then agents and movers.
"use strict";

const MARKED = 0.5; // how much of a cell the colour of a mark covers

class Board {
  // data: as `sjdsl/render/episode_data.py` writes it.
  constructor(canvas, data) {
    this.canvas = canvas;
    this.data = data;
    this.images = [];
    this.frames = allCells(data);
  }

  // Resolves when all pictures can be drawn.
  async load() {
    this.images = await Promise.all(this.data.pictures.map(async (url) => {
      const image = new Image();
      image.src = url;
      await image.decode();
      return image;
    }));
  }

  // Draws the moment of a number so that it fits into `width` pixels of the page; cells never get larger than their pictures.
  draw(number, width) {
    const { data, canvas } = this;
    const density = window.devicePixelRatio || 1;
    const cell = Math.max(2, Math.min(data.size, Math.floor((width * density) / data.width)));
    canvas.width = cell * data.width;
    canvas.height = cell * data.height;
    canvas.style.width = `${canvas.width / density}px`;
    const pen = canvas.getContext("2d");
    const moment = data.moments[number];
    this.frames[number].forEach((picture, at) => {
      pen.drawImage(this.images[picture], (at % data.width) * cell, Math.floor(at / data.width) * cell, cell, cell);
    });
    pen.globalAlpha = MARKED;
    moment.marks.forEach((cells, mark) => {
      pen.fillStyle = data.marks[mark].colour;
      cells.forEach((at) => pen.fillRect((at % data.width) * cell, Math.floor(at / data.width) * cell, cell, cell));
    });
    pen.globalAlpha = 1;
    moment.figures.forEach(([picture, row, col]) => pen.drawImage(this.images[picture], col * cell, row * cell, cell, cell));
  }
}

// Returns for each moment the picture of each cell; the data has only those that changed.
function allCells(data) {
  let last = new Uint16Array(data.height * data.width);
  return data.moments.map(({ cells }) => {
    if (cells.length) last = last.slice();
    for (let i = 0; i < cells.length; i += 2) last[cells[i]] = cells[i + 1];
    return last;
  });
}
