// What stands in place of the studio's server: workers that run Python, one for each socket that the page opens.

const KEPT = "sjdsl:"; // before the names of files in the browser's storage
const ahead = JSON.parse(document.querySelector("#ahead").textContent); // answers that were asked for when the playground was built
const message = (text) => { document.querySelector('[data-part="message"]').textContent = text; };

let loaded = Promise.resolve(); // workers load one after the other: the first page comes first
const workers = new Set();
let first = null; // the socket whose worker has the files, too
let speaking = null; // the socket of the language server: one that is opened anew takes its place, as its worker is as large

// A worker, as long as it lives. onMessage: of what it says once it is ready.
class Python {
  constructor(onMessage, onBroken) {
    this.onMessage = onMessage;
    this.ready = loaded.then(() => new Promise((resolve, reject) => {
      this.refuse = reject;
      if (this.isEnded) return reject(new Error("ended"));
      this.worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
      this.worker.addEventListener("error", (event) => reject(new Error(event.message ?? "a worker cannot be started")));
      this.worker.addEventListener("message", ({ data }) => {
        if (data.ready) resolve();
        else if (data.broken) { reject(new Error(data.broken)); onBroken(data.broken); }
        else this.onMessage(data);
      });
      for (const [path, text] of saved()) this.worker.postMessage({ keep: path, text });
    }));
    this.ready.catch((error) => { if (!this.isEnded) onBroken(error.message); });
    loaded = this.ready.catch(() => {});
    workers.add(this);
  }

  send(data) {
    this.ready.then(() => this.worker.postMessage(data), () => {});
  }

  end() {
    this.isEnded = true;
    workers.delete(this);
    this.worker?.terminate();
    this.refuse?.(new Error("ended")); // who waits for it to load goes on
  }
}

// As a WebSocket: what is sent to it is answered by Python. A request that takes too long ends the worker; another one is begun.
class Socket extends EventTarget {
  constructor(path) {
    super();
    first ??= this;
    this.part = path.slice(1);
    this.readyState = WebSocket.CONNECTING;
    this.turn = Promise.resolve();
    this.begin();
    this.python.ready.then(() => this.prepare(), () => {});
  }

  // The page waits ten seconds for an answer of the language server: on a slow machine its modules alone take longer.
  prepare() {
    if (this.part === "language") this.python.send({ prepare: true });
    else this.open();
  }

  open() {
    if (this === first) message("");
    this.readyState = WebSocket.OPEN;
    this.dispatchEvent(new Event("open"));
  }

  begin() {
    this.python = new Python((data) => this.hear(data), (reason) => this.broken(reason));
  }

  send(text) {
    if (this.part === "language") return this.python.send({ language: text });
    this.turn = this.turn.then(() => this.ask(text));
  }

  // Resolves when a request is answered, by Python or by the clock.
  ask(text) {
    const { id, do: what } = JSON.parse(text), seconds = transport.seconds[what] ?? transport.seconds.any;
    return this.python.ready.then(() => new Promise((resolve) => {
      const lost = (refused) => {
        this.python.end();
        if (this === first) for (const answer of waiting.values()) answer(JSON.stringify({ refused: "Python was started again: try once more" }));
        this.begin();
        this.hear({ bench: JSON.stringify({ id, do: what, refused, lost: true }) });
      };
      const clock = setTimeout(() => lost(`this took more than ${seconds} seconds and was stopped`), seconds * 1000);
      this.answered = () => { clearTimeout(clock); resolve(); };
      this.lost = lost;
      this.python.send({ bench: text });
    }));
  }

  hear(data) {
    if (data.prepared) return this.open();
    if (data.call !== undefined) return waiting.get(data.call)?.(data.answer);
    if (data.bench !== undefined) this.answered?.();
    this.dispatchEvent(new MessageEvent("message", { data: data.bench ?? data.language }));
  }

  broken(reason) {
    if (this.readyState !== WebSocket.OPEN) message(`Python could not be started: ${reason}`);
    else if (this.lost && this.part === "bench") this.lost("Python broke off; it starts again");
  }
}

function openSocket(path) {
  const socket = new Socket(path);
  if (socket.part === "language") {
    speaking?.python.end();
    speaking = socket;
  }
  return socket;
}

// ---- files, which this browser keeps

function saved() {
  const names = Object.keys(localStorage).filter((name) => name.startsWith(KEPT));
  return names.map((name) => [name.slice(KEPT.length), localStorage.getItem(name)]);
}

const waiting = new Map();
let number = 0;

// Answers as `fetch` does, with what the page's server would have said.
async function call(path, { method = "GET", body = "" } = {}) {
  if (method === "GET" && path in ahead.files) return { json: () => Promise.resolve(ahead.files[path]) };
  await first.python.ready;
  const id = ++number;
  const answer = await new Promise((resolve) => { waiting.set(id, resolve); first.python.send({ file: method, path, body, call: id }); });
  waiting.delete(id);
  const told = JSON.parse(answer);
  for (const [name, text] of Object.entries(told.written ?? {})) keep(name, text);
  return { json: () => Promise.resolve(told) };
}

function keep(path, text) {
  try {
    localStorage.setItem(KEPT + path, text);
  } catch {
    message("This browser keeps no files: download what you want to have again.");
  }
  for (const python of workers) if (python !== first.python) python.send({ keep: path, text });
  offer(path, text);
}

// A link to the file that was saved last.
function offer(path, text) {
  const link = document.querySelector("#download") ?? document.createElement("a");
  if (link.href) URL.revokeObjectURL(link.href);
  Object.assign(link, { id: "download", textContent: `Download ${path}`, download: path.slice(path.lastIndexOf("/") + 1) });
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  document.querySelector('[data-part="save"]').after(link);
}

// seconds: that a request may take; checks are played for a long time.
const transport = { openSocket, call, ahead, seconds: { any: 60, panel: 300 } };
globalThis.studioTransport = transport;
message("Loading Python…");
