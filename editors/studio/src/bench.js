// The bench: the process that plays the game. Requests go one at a time; of many changes of the same thing only the last is sent.

import { openSocket } from "./transport.js";

export class Bench {
  // path: of the socket; onLost: called with whether there is no connection; onOpen: called whenever there is a new one; onBusy: called with
  // whether a request waits for its answer.
  constructor(path, { onLost, onOpen, onBusy = () => {} }) {
    Object.assign(this, { path, onLost, onOpen, onBusy });
    this.waiting = new Map();
    this.next = new Map(); // by sort of request: the newest that has not been sent, while one is on its way
    this.number = 0;
    this.wasOpen = false;
    this.connect();
  }

  connect() {
    this.socket = openSocket(this.path);
    this.socket.addEventListener("open", () => { this.wasOpen = true; this.onLost(false); this.onOpen(); });
    this.socket.addEventListener("message", (event) => this.receive(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      for (const resolve of this.waiting.values()) resolve({ refused: "the connection to the studio was lost", lost: true });
      this.waiting.clear();
      this.onBusy(false);
      this.onLost(true);
      setTimeout(() => this.connect(), 1000);
    });
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  // Resolves to the answer; one that is refused has `refused`, the reason.
  ask(request) {
    if (!this.isOpen) return Promise.resolve({ refused: this.wasOpen ? "there is no connection to the studio" : "Loading…", lost: true });
    const id = ++this.number;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.onBusy(true);
      this.socket.send(JSON.stringify({ id, ...request }));
    });
  }

  // Sends a request, or keeps it until the one before of its sort is answered; calls `answered` with each answer to the newest so far.
  async latest(sort, request, answered) {
    const isOnItsWay = this.next.has(sort);
    this.next.set(sort, { request, answered });
    if (isOnItsWay) return;
    while (this.next.get(sort)) {
      const { request: now, answered: tell } = this.next.get(sort);
      this.next.set(sort, null);
      const answer = await this.ask(now);
      if (!this.next.get(sort)) tell(answer);
    }
    this.next.delete(sort);
  }

  receive(answer) {
    const resolve = this.waiting.get(answer.id);
    this.waiting.delete(answer.id);
    if (!this.waiting.size) this.onBusy(false);
    if (resolve) resolve(answer);
  }
}
