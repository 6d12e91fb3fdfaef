// Packages that are not beside the sources: they are installed in the build's folder, by the lock file of this one.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

/** {module, version, folder} of a package under `packages`/node_modules: its ES module. */
export async function loadPackage(packages, name) {
  const folder = join(packages, "node_modules", name);
  const description = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const root = description.exports?.["."] ?? {};
  const entry = root.import?.default ?? root.import ?? root.default ?? description.module ?? description.main;
  const path = typeof entry === "string" ? join(folder, entry) : createRequire(join(packages, "x")).resolve(name);
  const module = await import(pathToFileURL(path).href);
  return { module: module.default ?? module, names: module, version: description.version, folder: dirname(path), entry: path };
}
