// How the page reaches who answers: the studio's server, or what another page has put in its place before this script.

const meta = (name) => document.querySelector(`meta[name="${name}"]`).content;
const given = globalThis.studioTransport;
const asked = (path) => `${path}${path.includes("?") ? "&" : "?"}token=${encodeURIComponent(meta("token"))}`;

export const isServed = !given;
export const openSocket = given ? given.openSocket : (path) => new WebSocket(`ws://${location.host}${asked(path)}`);
export const ahead = given?.ahead; // what the bench will answer to the text of one game, { path, answer }, known before it can be asked
export const call = given ? given.call : (path, options) => fetch(asked(path), options);
