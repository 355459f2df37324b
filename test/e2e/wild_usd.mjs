// usage: node wild_usd.mjs FOLDER IN.usda OUT.obj: what tinyusdz, which npm installed in FOLDER, reads of a stage, as triangles in the
// stage's own axes and unit. Ends with 1 where it does not read the file.
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

const [folder, input, output] = process.argv.slice(2);
const home = path.resolve(folder, "node_modules/tinyusdz");
// It is built for pages, and asks whether it is in one.
process.type = "renderer";
globalThis.window = globalThis;
const { default: open } = await import(pathToFileURL(path.join(home, "tinyusdz.js")).href);
const module = await open({ wasmBinary: fs.readFileSync(path.join(home, "tinyusdz.wasm")) });
const stage = new module.TinyUSDZLoaderNative();
if (!stage.loadFromBinary(new Uint8Array(fs.readFileSync(input)), input)) process.exit(1);

const lines = [];
let first = 1;
function add(node) {
    if (node.nodeType === "mesh") {
        const { points, faceVertexIndices } = stage.getMesh(node.contentId);
        const m = Array.from(node.globalMatrix); // rows, which act from the right
        for (let i = 0; i < points.length; i += 3)
            lines.push("v " + [0, 1, 2].map((k) => points[i] * m[k] + points[i + 1] * m[4 + k] + points[i + 2] * m[8 + k] + m[12 + k]).join(" "));
        for (let i = 0; i < faceVertexIndices.length; i += 3)
            lines.push("f " + [0, 1, 2].map((k) => faceVertexIndices[i + k] + first).join(" "));
        first += points.length / 3;
    }
    for (const child of node.children ?? []) add(child);
}
for (let i = 0; i < stage.numRootNodes(); i++) add(stage.getRootNode(i));
fs.writeFileSync(output, lines.join("\n") + "\n");
