// One worker of the playground: Python, and in it what the studio's server would do. Requests and answers as its page has them.

import { INTEGRITY, PLACE } from "./pyodide.js";

const speak = (message) => postMessage({ language: message });
const reason = (error) => error.message ?? String(error);
const SITE = "/lib/python3.14/site-packages";
const place = new URL(PLACE, import.meta.url).href; // of Pyodide: beside this file, or on another server

// A file of Pyodide has to be the one that was built with, wherever it comes from. Pyodide itself would wait for a missing one for ever.
const load = globalThis.fetch;
const refused = new Promise((_, refuse) => {
  globalThis.fetch = (address, options) => {
    const url = String(address), name = url.startsWith(place) ? url.slice(place.length) : "";
    if (!(name in INTEGRITY)) return load(address, options);
    const answer = load(address, { ...options, integrity: INTEGRITY[name] });
    answer.catch((error) => refuse(new Error(`${url} cannot be loaded, or is not the file that the playground was built with (${error.message})`)));
    return answer;
  };
});

// import() checks nothing: a module is loaded as a file first.
async function module(name) {
  const url = URL.createObjectURL(new Blob([await bytes(place + name)], { type: "text/javascript" }));
  return import(url).finally(() => URL.revokeObjectURL(url));
}

async function pyodide() {
  const [{ loadPyodide }, { default: createPyodideModule }] = await Promise.all(["pyodide.mjs", "pyodide.asm.mjs"].map(module));
  return loadPyodide({ indexURL: place, createPyodideModule });
}

async function begin() {
  const [python, core] = await Promise.race([Promise.all([pyodide(), bytes("pydantic_core.whl")]), refused]);
  python.unpackArchive(await bytes("packages.zip"), "zip", { extractDir: SITE });
  python.unpackArchive(core, "wheel");
  const { Serverless } = python.pyimport("sjdsl.studio.serverless");
  return Serverless(python.pyimport("pathlib").Path("/folder"));
}

async function bytes(name) {
  const answer = await fetch(new URL(name, import.meta.url));
  if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

// Messages come in the order in which they were sent, also those that were sent while Python was loading.
let ready = begin();
ready.then(() => postMessage({ ready: true }), (error) => postMessage({ broken: reason(error) }));
addEventListener("message", ({ data }) => {
  ready = ready.then((studio) => {
    if (data.keep) studio.keep(data.keep, data.text);
    else if (data.prepare) { studio.prepare_language(speak); postMessage({ prepared: true }); }
    else if (data.language) studio.language(data.language, speak);
    else if (data.file) postMessage({ call: data.call, answer: studio.file(data.file, data.path, data.body) });
    else postMessage({ bench: studio.bench(data.bench) });
    return studio;
  });
  ready.catch((error) => postMessage({ broken: reason(error) }));
});
