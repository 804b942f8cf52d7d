// The files of the folder that the studio was started in.

export class Files {
  constructor(token) {
    this.token = token;
  }

  async games() {
    return (await this.call("/games")).json();
  }

  // Resolves to { text, digest } or { refused }.
  async read(path) {
    return (await this.call(`/file?path=${encodeURIComponent(path)}`)).json();
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
