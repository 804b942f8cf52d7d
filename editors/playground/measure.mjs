// Measures what the playground takes, in processor seconds of Node: node measure.mjs ../../build/playground

import { readFileSync } from "node:fs";
import { loadPyodide } from "pyodide";

const folder = process.argv[2], bytes = (name) => new Uint8Array(readFileSync(`${folder}/${name}`));
const used = () => { const { user, system } = process.cpuUsage(); return (user + system) / 1e6; };
const told = (what, began) => console.log(`${what}: ${(used() - began).toFixed(2)} s`);
const median = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

const python = await loadPyodide();
python.unpackArchive(bytes("packages.zip"), "zip", { extractDir: "/lib/python3.14/site-packages" });
python.unpackArchive(bytes("pydantic_core.whl"), "wheel");
told("Python", 0);
let began = used();
const studio = python.pyimport("sjdsl.studio.serverless").Serverless(python.pyimport("pathlib").Path("/folder"));
told("the studio's modules", began);
for (const path of ["example:clean_up.sj", "example:coins.sj"]) {
  const { text } = JSON.parse(studio.file("GET", `/file?path=${path}`));
  const ask = (request) => JSON.parse(studio.bench(JSON.stringify(request)));
  const open = (version) => ask({ do: "text", version, path, text: `${text}# ${"a".repeat(version)}` });
  const seconds = (request, count) => Array.from({ length: count }, (_, n) => { const before = used(); request(n + 1); return used() - before; });
  began = used();
  open(0);
  told(`${path}, the first time`, began);
  open(1);
  console.log(`${path}, a keystroke: median ${(1000 * median(seconds(open, 20))).toFixed(0)} ms`);
  console.log(`${path}, a step: median ${(1000 * median(seconds(() => ask({ do: "step" }), 20))).toFixed(0)} ms`);
}
