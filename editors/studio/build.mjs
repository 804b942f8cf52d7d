// Builds the script of the studio's page, and the list of licences of what is in it.

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { build } from "esbuild";

const PAGE = "../../sjdsl/studio/page";

// The same digest is computed by tests/studio/test_bundle.py: a bundle of older sources is found.
const sources = [...readdirSync("src").sort().map((name) => `src/${name}`), "package-lock.json"];
const digest = createHash("sha256");
for (const name of sources) digest.update(readFileSync(name));

const made = await build({
  entryPoints: ["src/main.js"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  metafile: true,
  banner: { js: `// Built by editors/studio; sources ${digest.digest("hex")}` },
  outfile: `${PAGE}/studio.js`,
});

const packages = new Set(
  Object.keys(made.metafile.inputs).flatMap((path) => path.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1] ?? []),
);
const licences = [...packages].sort().map((name) => {
  const folder = `node_modules/${name}`;
  const { version } = JSON.parse(readFileSync(`${folder}/package.json`, "utf-8"));
  const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
  if (!file) throw new Error(`${name} has no licence file`);
  return `${name} ${version}\n\n${readFileSync(`${folder}/${file}`, "utf-8").trim()}\n`;
});
writeFileSync(`${PAGE}/studio.licences.txt`, `What studio.js contains, and under which licences.\n\n${licences.join("\n----\n\n")}`);
