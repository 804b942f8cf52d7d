// The files of the folder that the studio was started in.

import { call } from "./transport.js";

const send = async (method, path, given) => (await call(path, { method, body: JSON.stringify(given), headers: { "content-type": "application/json" } })).json();

export class Files {
  // Resolves to { games, examples, tour }, the paths of each.
  async games() {
    return (await call("/games")).json();
  }

  // Resolves to { steps } of the tour, each { title, text, game }.
  async tour() {
    return (await call("/tour")).json();
  }

  // Resolves to { text, digest, uri } or { refused }.
  async read(path) {
    return (await call(`/file?path=${encodeURIComponent(path)}`)).json();
  }

  // Writes a text as a new file, with the files that the game at `example` needs; resolves to { digest } or { refused }.
  copy(example, path, text) {
    return send("POST", "/copy", { example, path, text });
  }

  // Makes a game with its map: the starting one, or a copy of the game at the path `like`; resolves to { digest } or { refused }.
  make(path, like) {
    return send("POST", "/new", { path, like });
  }

  // Resolves to { digest }, or { refused } and, if somebody else has changed the file, `changed`.
  write(path, text, digest) {
    return send("PUT", "/file", { path, text, digest });
  }
}
