// The files of the folder that the studio was started in.

import { call } from "./transport.js";

export class Files {
  // Resolves to { games, examples, tour }, the paths of each, and packages, each { release, games }.
  async games() {
    return (await call("/games")).json();
  }

  // Resolves to { policies }, those trained in the folder, each as [name, game it was trained on].
  async policies() {
    return (await call("/policies")).json();
  }

  // Resolves to { steps } of the tour, each { title, text, game }.
  async tour() {
    return (await call("/tour")).json();
  }

  // Resolves to { text, digest, uri } or { refused }.
  async read(path) {
    return (await call(`/file?path=${encodeURIComponent(path)}`)).json();
  }

  // Writes the text of an example as a new file; resolves to { digest } or { refused }.
  async copy(example, path, text) {
    const body = JSON.stringify({ example, path, text });
    return (await call("/copy", { method: "POST", body, headers: { "content-type": "application/json" } })).json();
  }

  // Resolves to { digest }, or { refused } and, if somebody else has changed the file, `changed`.
  async write(path, text, digest) {
    const body = JSON.stringify({ path, text, digest });
    return (await call("/file", { method: "PUT", body, headers: { "content-type": "application/json" } })).json();
  }
}
