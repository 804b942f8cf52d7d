// Who drives the agents that nobody does: at random, a policy of the file, or one that was trained in this folder.

import { find } from "./dom.js";

export class Drivers {
  // files: of the studio; ask: sends a request to the bench; say: shows a message.
  constructor({ files, ask, say }) {
    Object.assign(this, { files, ask, say });
    this.trained = []; // each as [name, game it was trained on]
    this.game = null;
    const menu = find("others");
    menu.addEventListener("change", () => this.choose(menu.value));
    menu.addEventListener("pointerenter", () => this.list());
    menu.addEventListener("focus", () => this.list());
  }

  // Fills the menu for a game, as the bench describes it.
  show(game) {
    this.game = game;
    const option = (name, text = name) => new Option(text, name, false, name === game.others);
    const group = (label, policies) => {
      const made = document.createElement("optgroup");
      made.label = label;
      made.append(...policies.map(([name, on]) => option(name, on === game.name ? name : `${name} (${on})`)));
      return policies.length ? [made] : [];
    };
    find("others").replaceChildren(
      ...game.policies.map((name) => option(name)),
      ...group("trained in this folder", this.trained.filter(([, on]) => on === game.name)),
      ...group("trained on other games", this.trained.filter(([, on]) => on !== game.name)),
    );
    if (find("others").value !== game.others) find("others").append(option(game.others));
  }

  // Looks which policies there are: a run may have come to its end in the meantime.
  async list() {
    const found = await this.files.policies().then(({ policies }) => policies, () => this.trained);
    if (JSON.stringify(found) === JSON.stringify(this.trained)) return;
    this.trained = found;
    if (this.game) this.show(this.game);
  }

  async choose(policy) {
    this.say(`loading ${policy}…`);
    const answer = await this.ask({ do: "others", policy });
    if (answer.refused) return this.show(this.game);
    this.game.others = answer.others;
    this.say(answer.note);
  }
}
