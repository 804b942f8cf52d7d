// The page of an episode: plays it, goes to any moment, and tells what each agent did and got.
"use strict";

const FORMAT = 1;
const SPEEDS = [1, 2, 4, 8, 16, 32]; // moments a second

async function showEpisode(root, data) {
  const find = (name) => root.querySelector(`[data-part="${name}"]`);
  if (data.format !== FORMAT) {
    find("message").hidden = false;
    find("message").textContent = `This page shows episodes of format ${FORMAT}, and this is one of format ${data.format}.`;
    return;
  }
  find("title").textContent = data.title;
  find("played").textContent = playedBy(data);
  const images = await Promise.all(data.pictures.map(loadPicture));
  const cells = allCells(data);
  const last = data.moments.length - 1;
  let number = 0, timer = null;
  const rows = agentRows(find("agents"), data);
  const moveCursor = plotReturns(find("plot"), data, (at) => show(at));
  fillLegend(find("legend"), data);
  const scrub = find("scrub"), play = find("play"), speed = find("speed");
  scrub.max = last;
  for (const rate of [...new Set([...SPEEDS, data.speed])].sort((a, b) => a - b)) {
    speed.append(new Option(`${rate}/s`, rate, rate === data.speed, rate === data.speed));
  }

  function show(wanted) {
    number = Math.min(last, Math.max(0, wanted));
    const moment = data.moments[number];
    paintBoard(find("board"), data, images, cells[number], moment, find("stage").clientWidth);
    scrub.value = number;
    find("step").textContent = `step ${moment.step}` + (moment.done ? ", the episode is over" : "");
    find("world").textContent = moment.world.map(([name, value]) => `${name} ${value}`).join(" · ");
    rows.forEach((row, agent) => row(moment, agent));
    find("events").textContent = moment.events.map(([name, count]) => describeEvent(name, count)).join(" · ");
    find("why").replaceChildren(...moment.why.flatMap((text, agent) => (text ? [reasonOf(text, agent)] : [])));
    moveCursor(number);
  }

  function name(label, icon) {
    play.title = label;
    play.setAttribute("aria-label", label);
    play.querySelector("use").setAttribute("href", icon);
  }

  function pause() {
    clearInterval(timer);
    timer = null;
    name("Play", "#icon-play");
    find("step").ariaLive = "polite";
  }

  function start() {
    if (number === last) show(0);
    name("Pause", "#icon-pause");
    find("step").ariaLive = "off"; // many steps a second are too many to be read out
    timer = setInterval(() => (number < last ? show(number + 1) : pause()), 1000 / Number(speed.value));
  }

  play.addEventListener("click", () => (timer === null ? start() : pause()));
  find("again").addEventListener("click", () => { pause(); show(0); });
  find("back").addEventListener("click", () => { pause(); show(number - 1); });
  find("forward").addEventListener("click", () => { pause(); show(number + 1); });
  scrub.addEventListener("input", () => { pause(); show(Number(scrub.value)); });
  speed.addEventListener("change", () => { if (timer !== null) { pause(); start(); } });
  new ResizeObserver(() => show(number)).observe(find("stage"));
  if (window.parent !== window) {
    new ResizeObserver(tellHeight).observe(root);
    window.addEventListener("message", tellHeight); // of a page that began to listen later
  }
  root.ownerDocument.addEventListener("keydown", (event) => {
    if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " ") play.click();
    else if (event.key === "ArrowLeft") find("back").click();
    else if (event.key === "ArrowRight") find("forward").click();
    else if (event.key === "Home") { pause(); show(0); }
    else if (event.key === "End") { pause(); show(last); }
    else return;
    event.preventDefault();
  });
  show(0);
}

// Tells the page around this one how high it is, so that its frame can be as high.
function tellHeight() {
  window.parent.postMessage({ episodeHeight: document.documentElement.offsetHeight }, "*");
}

// Says who plays which agents, and the seed.
function playedBy(data) {
  const agentsOf = new Map();
  (data.players ?? []).forEach((player, agent) => agentsOf.set(player, [...(agentsOf.get(player) ?? []), agent]));
  const parts = [...agentsOf].map(([player, agents]) => `${agents.length > 1 ? "Agents" : "Agent"} ${agents.join(", ")}: ${player}`);
  if (data.seed !== null && data.seed !== undefined) parts.push(`seed ${data.seed}`);
  return parts.join(" · ");
}

// Makes a row for each agent; returns what fills each of them from a moment.
function agentRows(table, data) {
  if (!data.has) table.querySelector('[data-part="has"]').remove();
  return data.agents.map((colour, agent) => {
    const row = table.tBodies[0].insertRow();
    const [name, action, reward, total, has] = Array.from({ length: data.has ? 5 : 4 }, () => row.insertCell());
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = colour;
    const label = document.createTextNode(String(agent));
    name.append(swatch, label);
    return (moment) => {
      const isAway = moment.away.includes(agent);
      row.className = isAway ? "away" : "";
      label.textContent = isAway ? `${agent}, away` : String(agent);
      action.textContent = moment.actions.length ? data.actions[moment.actions[agent]] : "";
      reward.textContent = moment.rewards[agent] === 0 ? "" : signed(moment.rewards[agent]);
      total.textContent = plain(moment.returns[agent]);
      has?.replaceChildren(...havings(data, moment, agent));
    };
  });
}

// Returns what an agent has: each row behind its name, and then what else it is shown of itself.
function havings(data, moment, agent) {
  const parts = [];
  let last = null;
  for (const [row, picture, amount] of moment.held[agent]) {
    if (row !== last) parts.push(parts.length ? ` ${row} ` : `${row} `);
    parts.push(pictureOf(data, picture), plain(amount));
    last = row;
  }
  const own = moment.own[agent].map(([name, value]) => `${name} ${value}`).join(", ");
  return own ? [...parts, parts.length ? ` ${own}` : own] : parts;
}

function reasonOf(text, agent) {
  const line = document.createElement("li");
  line.textContent = `agent ${agent}: ${text}`;
  return line;
}

function fillLegend(place, data) {
  for (const [picture, text] of data.legend) {
    const item = document.createElement("li");
    item.append(pictureOf(data, picture), text);
    place.append(item);
  }
}

function pictureOf(data, picture) {
  const image = document.createElement("img");
  image.src = data.pictures[picture];
  image.alt = "";
  return image;
}

// An event of everybody has one count, one of agents a count for each.
function describeEvent(name, count) {
  if (!Array.isArray(count)) return `${name} ${count}`;
  const counted = count.flatMap((times, agent) => (times ? [times === 1 ? `${agent}` : `${agent} (${times} times)`] : []));
  return `${name}: agent${counted.length > 1 ? "s" : ""} ${counted.join(", ")}`;
}

const plain = (value) => String(Number(value.toPrecision(6)));
const signed = (value) => (value > 0 ? "+" : "−") + plain(Math.abs(value));

document.addEventListener("DOMContentLoaded", () => {
  showEpisode(document.body, JSON.parse(document.getElementById("episode").textContent));
});
