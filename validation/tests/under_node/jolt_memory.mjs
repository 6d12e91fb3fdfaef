// Prints how many bytes of Jolt's memory 200 worlds leave behind, beyond what the first ones do. jolt_memory.mjs ROOT PACKAGES,
// the scene on standard input.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [root, packages] = process.argv.slice(2);
const source = (path) => import(pathToFileURL(join(root, "reference", path)).href);
const { loadPackage } = await source("node/packages.mjs");
const { readScene } = await source("node/scene.mjs");
const { settings } = await source("jolt/settings.mjs");
const { JoltWorld } = await source("jolt/world.mjs");

const one = await loadPackage(packages, "jolt-physics"),
  jolt = await one.module();
const scene = readScene(JSON.parse(readFileSync(0, "utf8"))),
  chosen = Object.fromEntries(settings.map(({ name, value }) => [name, value]));
const made = (count) => {
  for (let k = 0; k < count; ++k) {
    const world = new JoltWorld(jolt, scene, chosen, true);
    world.step(1 / 240, []);
    world.free();
  }
  return jolt.JoltInterface.prototype.sGetFreeMemory();
};
console.log(made(5) - made(200));
