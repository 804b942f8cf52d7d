// Painting: puts glyphs on cells of the map, in the text or in the map's own file.

// studio: { open, files, bench, isExample, glyph, view, say, changed }, of which glyph and view are asked each time. changed: called when
// the file of the map has changed. Returns what puts the chosen glyph on a cell, one after the other: each change is of the text that the one
// before has made.
export function painter({ open, files, bench, isExample, glyph: chosen, view, say, changed }) {
  let painted = Promise.resolve();
  return (row, col) => { painted = painted.then(() => paint(row, col)); };

  async function paint(row, col) {
    const file = open.game.map_file;
    if (file && isExample()) return say("The map of an example is in a file of its own: save a copy first.");
    if (file && open.map?.path !== file) {
      const read = await files.read(file);
      if (read.refused) return say(read.refused);
      open.map = { path: file, text: read.text, saved: read.text, digest: read.digest };
    }
    const answer = await bench.ask({ do: "paint", row, col, glyph: chosen() });
    if (answer.refused) return say(answer.refused);
    const { path, start, end, before, glyph } = answer.change;
    if (path === file) {
      if (open.map.text.slice(start, end) !== before) return say("the file of the map has changed, or its lines end as on Windows: change it in an editor");
      open.map.text = open.map.text.slice(0, start) + glyph + open.map.text.slice(end);
      changed();
    } else {
      if (view().state.doc.sliceString(start, end) !== before) return; // the text has changed in the meantime
      view().dispatch({ changes: { from: start, to: end, insert: glyph } });
    }
    await answered();
  }

  // Resolves when the newest text is answered.
  function answered() {
    return new Promise((resolve) => {
      const look = () => (bench.next.has("text") ? setTimeout(look, 5) : resolve());
      look();
    });
  }
}
