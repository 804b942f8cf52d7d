// Small pictures of games: those of bundled games are files, of any other this browser keeps what its board looked like when it was opened.

const KEPT = "sjdsl-thumbnail:"; // before the paths of games in the browser's storage
const WIDTH = 96; // pixels
const BUNDLED = /^(?:example|tour):(?:.*\/)?(\w+)\.sj$/;

// Returns the address of a picture, null if there is none.
export function thumbnailOf(path) {
  const bundled = path.match(BUNDLED);
  if (bundled) return new URL(`thumbnails/${bundled[1]}.png`, import.meta.url).href;
  try {
    return localStorage.getItem(KEPT + path);
  } catch {
    return null;
  }
}

export function keepThumbnail(path, board) {
  if (BUNDLED.test(path) || !board.width) return;
  const small = document.createElement("canvas");
  small.width = WIDTH;
  small.height = Math.max(1, Math.round((WIDTH * board.height) / board.width));
  small.getContext("2d").drawImage(board, 0, 0, small.width, small.height);
  try { localStorage.setItem(KEPT + path, small.toDataURL("image/jpeg")); } catch { /* then it is listed without one */ }
}
