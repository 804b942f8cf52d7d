// Draws the board of an episode on a canvas: cells, then beams, agents and movers.
"use strict";

// Draws one moment so that it fits into `width` pixels of the page; cells never get larger than their pictures.
// map: height, width in cells, size of a picture in pixels; cells: the picture of each cell; moment: its figures.
function paintBoard(canvas, map, images, cells, moment, width) {
  const density = window.devicePixelRatio || 1;
  const cell = Math.max(2, Math.min(map.size, Math.floor((width * density) / map.width)));
  const put = (picture, row, col) => pen.drawImage(images[picture], col * cell, row * cell, cell, cell);
  canvas.width = cell * map.width;
  canvas.height = cell * map.height;
  canvas.style.width = `${canvas.width / density}px`;
  const pen = canvas.getContext("2d");
  cells.forEach((picture, at) => put(picture, Math.floor(at / map.width), at % map.width));
  moment.figures.forEach(([picture, row, col]) => put(picture, row, col));
}

// Resolves to a picture that can be drawn: an SVG file as pixels, which is done once.
async function loadPicture(url) {
  const image = new Image();
  image.src = url;
  await image.decode();
  const picture = document.createElement("canvas");
  picture.width = image.naturalWidth;
  picture.height = image.naturalHeight;
  picture.getContext("2d").drawImage(image, 0, 0);
  return picture;
}

// Writes the pictures of the cells that changed, [cell, picture, cell, picture, …], over those of before.
function changeCells(cells, changed) {
  for (let i = 0; i < changed.length; i += 2) cells[changed[i]] = changed[i + 1];
}

// Returns for each moment the picture of each cell; the data has only those that changed.
function allCells(data) {
  let last = new Uint16Array(data.height * data.width);
  return data.moments.map((moment) => {
    if (moment.cells.length) last = last.slice();
    changeCells(last, moment.cells);
    return last;
  });
}
