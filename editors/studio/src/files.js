// The files of the folder that the studio was started in.

export class Files {
  constructor(token) {
    this.token = token;
  }

  // Resolves to { games, examples, tour }, the paths of each.
  async games() {
    return (await this.call("/games")).json();
  }

  // Resolves to { policies }, those trained in the folder, each as [name, game it was trained on].
  async policies() {
    return (await this.call("/policies")).json();
  }

  // Resolves to { steps } of the tour, each { title, text, game }.
  async tour() {
    return (await this.call("/tour")).json();
  }

  // Resolves to { text, digest } or { refused }.
  async read(path) {
    return (await this.call(`/file?path=${encodeURIComponent(path)}`)).json();
  }

  // Writes the text of an example as a new file; resolves to { digest } or { refused }.
  async copy(example, path, text) {
    const body = JSON.stringify({ example, path, text });
    return (await this.call("/copy", { method: "POST", body, headers: { "content-type": "application/json" } })).json();
  }

  // Resolves to { digest }, or { refused } and, if somebody else has changed the file, `changed`.
  async write(path, text, digest) {
    const body = JSON.stringify({ path, text, digest });
    return (await this.call("/file", { method: "PUT", body, headers: { "content-type": "application/json" } })).json();
  }

  call(path, options) {
    return fetch(`${path}${path.includes("?") ? "&" : "?"}token=${encodeURIComponent(this.token)}`, options);
  }
}
