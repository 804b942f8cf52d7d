// One worker of the playground: Python, and in it what the studio's server would do. Requests and answers as its page has them.

import { loadPyodide } from "./pyodide/pyodide.mjs";

const SITE = "/lib/python3.14/site-packages";

async function begin() {
  const [python, core] = await Promise.all([loadPyodide({ indexURL: new URL("./pyodide/", import.meta.url).href }), bytes("pydantic_core.whl")]);
  python.unpackArchive(await bytes("packages.zip"), "zip", { extractDir: SITE });
  python.unpackArchive(core, "wheel");
  const { Serverless } = python.pyimport("sjdsl.studio.serverless");
  return Serverless(python.pyimport("pathlib").Path("/folder"));
}

async function bytes(name) {
  const answer = await fetch(new URL(`./${name}`, import.meta.url));
  if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status}`);
  return new Uint8Array(await answer.arrayBuffer());
}

// Messages come in the order in which they were sent, also those that were sent while Python was loading.
let ready = begin();
ready.then(() => postMessage({ ready: true }), (error) => postMessage({ broken: String(error) }));
addEventListener("message", ({ data }) => {
  ready = ready.then((studio) => {
    if (data.keep) studio.keep(data.keep, data.text);
    else if (data.language) studio.language(data.language, (message) => postMessage({ language: message }));
    else if (data.file) postMessage({ call: data.call, answer: studio.file(data.file, data.path, data.body) });
    else postMessage({ bench: studio.bench(data.bench) });
    return studio;
  });
  ready.catch((error) => postMessage({ broken: String(error) }));
});
