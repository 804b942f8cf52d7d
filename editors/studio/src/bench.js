// The bench: the process that plays the game. Requests go one at a time; of many changes of the text only the last is sent.

import { openSocket } from "./transport.js";

export class Bench {
  // path: of the socket; onLost: called with whether there is no connection; onOpen: called whenever there is a new one.
  constructor(path, { onLost, onOpen }) {
    Object.assign(this, { path, onLost, onOpen });
    this.waiting = new Map();
    this.number = 0;
    this.nextText = null;
    this.textOnItsWay = false;
    this.connect();
  }

  connect() {
    this.socket = openSocket(this.path);
    this.socket.addEventListener("open", () => { this.onLost(false); this.onOpen(); });
    this.socket.addEventListener("message", (event) => this.receive(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      for (const resolve of this.waiting.values()) resolve({ refused: "the connection to the studio was lost", lost: true });
      this.waiting.clear();
      this.onLost(true);
      setTimeout(() => this.connect(), 1000);
    });
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  // Resolves to the answer; one that is refused has `refused`, the reason.
  ask(request) {
    if (!this.isOpen) return Promise.resolve({ refused: "there is no connection to the studio", lost: true });
    const id = ++this.number;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.socket.send(JSON.stringify({ id, ...request }));
    });
  }

  // Sends a text, or keeps it until the one before is answered; calls `answered` with each answer that is about the newest text so far.
  async text(request, answered) {
    this.nextText = { request, answered };
    if (this.textOnItsWay) return;
    this.textOnItsWay = true;
    while (this.nextText) {
      const { request: now, answered: tell } = this.nextText;
      this.nextText = null;
      const answer = await this.ask({ do: "text", ...now });
      if (!this.nextText) tell(answer);
    }
    this.textOnItsWay = false;
  }

  receive(answer) {
    const resolve = this.waiting.get(answer.id);
    this.waiting.delete(answer.id);
    if (resolve) resolve(answer);
  }
}
