// Texts that are not saved yet, kept in this browser until they are: a page that is reloaded or closed loses none.

const KEPT = "sjdsl-draft:"; // before the paths of games in the browser's storage

// draft: { text, map, digest }, of the text, of the file of its map if somebody has painted it, and of the file that both are changes of.
// Returns whether the browser keeps it.
export function keepDraft(path, draft) {
  try {
    localStorage.setItem(KEPT + path, JSON.stringify(draft));
    return true;
  } catch {
    return false;
  }
}

export function dropDraft(path) {
  try { localStorage.removeItem(KEPT + path); } catch { /* then there is none */ }
}

export function draftOf(path) {
  try {
    return JSON.parse(localStorage.getItem(KEPT + path));
  } catch {
    return null;
  }
}
