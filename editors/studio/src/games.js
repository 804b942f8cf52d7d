// Which games there are, and the windows in which one is opened, made anew, or saved under another name.

import { coded, element, find } from "./dom.js";
import { thumbnailOf } from "./thumbnails.js";

// What stands before the path of a game that is only read: bundled, or of the tour.
export const prefixOf = (path) => path.match(/^(example:|tour:)/)?.[0] ?? "";
export const nameOf = (path) => path.slice(prefixOf(path).length);

export class Games {
  // files: of the studio; current: asked for the path of the open game; open: called with a path, and whether it has the text that is open.
  constructor({ files, current, open }) {
    Object.assign(this, { files, current, open });
    this.groups = []; // each [label, paths]
    this.titles = {}; // by path
    find("files").addEventListener("click", () => this.choose());
    find("new").addEventListener("click", () => this.make());
  }

  // Asks which games there are; resolves to the path of the one to begin with.
  async list() {
    const { games, examples, tour, titles } = await this.files.games();
    this.titles = titles;
    this.groups = [["In this folder", games], ["Tour", tour], ["Bundled games", examples]].filter(([, paths]) => paths.length);
    return games[0] || tour[0];
  }

  async choose() {
    await this.list();
    const search = element("input", { type: "search", "aria-label": "Find a game", placeholder: "Find a game", autofocus: true });
    const games = element("div", { class: "games", tabindex: "-1" }, ...this.groups.map(([label, paths]) => element("section", {}, element("h3", {}, label),
      element("ul", {}, ...paths.map((path) => element("li", {}, element("button", {
        "data-path": path, "aria-current": path === this.current() ? "true" : null, onclick: () => { window.close(); this.open(path, false); },
      }, picture(path), element("span", {}, element("span", { class: "of" }, this.titles[path] || nameOf(path)), element("span", { class: "path" }, nameOf(path))))))))));
    search.addEventListener("input", () => {
      const wanted = search.value.toLowerCase();
      for (const item of games.querySelectorAll("li")) item.hidden = ![wanted, wanted.replaceAll(" ", "_")].some((text) => item.textContent.toLowerCase().includes(text));
      for (const group of games.children) group.hidden = !group.querySelector("li:not([hidden])");
    });
    search.addEventListener("keydown", (event) => { if (event.key === "Enter") games.querySelector("section:not([hidden]) li:not([hidden]) button")?.click(); });
    const window = show("Open a game", [search, games], []);
  }

  // A new game in the folder: the starting one of `sjdsl new`, or a copy of another.
  async make() {
    await this.list();
    const like = element("select", { "aria-label": "Start from" }, new Option("a small dilemma to change", ""), ...this.groups.map(([label, paths]) => {
      const group = element("optgroup", { label });
      group.append(...paths.map((path) => new Option(nameOf(path), path)));
      return group;
    }));
    this.name("New game", "my_game.sj", [element("label", {}, element("span", {}, "Start from"), like)], "Create", (path) => this.files.make(path, like.value), false);
  }

  // Asks for the name under which a text is saved. write: called with it, resolves to an answer of `files`.
  saveAs(write) {
    this.name("Save as", nameOf(this.current()).split("/").pop(), [], "Save", write, true);
  }

  name(title, suggested, fields, verb, write, isSaved) {
    const name = element("input", { value: suggested, "aria-label": "Name", autofocus: true, spellcheck: "false" }), wrong = element("p", { class: "refused", role: "alert" });
    const done = async () => {
      const path = name.value.endsWith(".sj") ? name.value : `${name.value}.sj`, answer = await write(path);
      if (answer.refused) { wrong.replaceChildren(...coded(answer.refused)); return name.focus(); }
      window.close();
      this.open(path, isSaved);
    };
    name.addEventListener("keydown", (event) => { if (event.key === "Enter") done(); });
    const window = show(title, [element("label", {}, element("span", {}, "Name"), name), ...fields, wrong], [element("button", { class: "main", onclick: done }, verb)]);
    name.setSelectionRange(0, suggested.replace(/\.sj$/, "").length);
  }
}

function picture(path) {
  const address = thumbnailOf(path);
  return address ? element("img", { src: address, alt: "", loading: "lazy" }) : element("span", { class: "none" });
}

function show(title, parts, buttons) {
  const made = element("dialog", { "aria-labelledby": "dialog-title" }, element("h2", { id: "dialog-title" }, title), ...parts,
    element("div", { class: "row end" }, element("button", { onclick: () => made.close() }, "Cancel"), ...buttons));
  made.addEventListener("close", () => made.remove());
  made.addEventListener("click", (event) => { if (event.target === made) made.close(); }); // beside the window
  document.body.append(made);
  made.showModal();
  return made;
}
