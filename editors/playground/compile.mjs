// Compiles packages for Pyodide's Python, which then has not to be done in the browser: node compile.mjs SOURCES.zip WHEEL COMPILED.zip

import { readFileSync, writeFileSync } from "node:fs";
import { loadPyodide } from "pyodide";

const [sources, wheel, compiled] = process.argv.slice(2);
const python = await loadPyodide();
python.unpackArchive(new Uint8Array(readFileSync(sources)), "zip", { extractDir: "/packages" });
python.runPython(`
import compileall, pathlib, zipfile
assert compileall.compile_dir("/packages", quiet=1, legacy=True), "some file is no Python of this version"
with zipfile.ZipFile("/compiled.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
    for path in sorted(pathlib.Path("/packages").rglob("*")):
        if path.is_file() and path.suffix != ".py":
            packed.write(path, path.relative_to("/packages"))
`);
writeFileSync(compiled, python.FS.readFile("/compiled.zip"));

// A build that cannot play a game is none.
python.unpackArchive(new Uint8Array(readFileSync(compiled)), "zip", { extractDir: "/site" });
python.unpackArchive(new Uint8Array(readFileSync(wheel)), "wheel");
console.log(python.runPython(`
import json, pathlib, sys
sys.path.insert(0, "/site")
from sjdsl.studio.serverless import Serverless
studio = Serverless(pathlib.Path("/folder"))
text = json.loads(studio.file("GET", "/file?path=example:coins.sj"))["text"]
opened = json.loads(studio.bench(json.dumps({"do": "text", "version": 1, "path": "example:coins.sj", "text": text})))
assert opened["compiles"] and json.loads(studio.bench('{"do": "step"}'))["at"] == 1
f"Python {sys.version.split()[0]}: coins is played"
`));
