// Packages that are not beside the sources: they are installed in the build's folder, by the lock file of this one.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

/** {version, entry} of a package under `packages`/node_modules: its version and the path of its ES module. */
export function describePackage(packages, name) {
  const folder = join(packages, "node_modules", name);
  const description = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const root = description.exports?.["."] ?? {};
  const entry = root.import?.default ?? root.import ?? root.default ?? description.module ?? description.main;
  return {
    version: description.version,
    entry: typeof entry === "string" ? join(folder, entry) : createRequire(join(packages, "x")).resolve(name),
  };
}

/** {module, version, folder, entry} of a package: `module` is its default export, `names` are all. */
export async function loadPackage(packages, name) {
  const { version, entry } = describePackage(packages, name),
    names = await import(pathToFileURL(entry).href);
  return { module: names.default ?? names, names, version, folder: dirname(entry), entry };
}
