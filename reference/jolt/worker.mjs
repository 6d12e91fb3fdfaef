// Jolt as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: world.mjs, shapes.mjs, joints.mjs.
import { fileURLToPath } from "node:url";
import { loadPackage } from "../node/packages.mjs";
import { serve } from "../node/protocol.mjs";
import { joltRival } from "./jolt.mjs";

/** `packages`: the folder that has node_modules. */
export async function main(packages) {
  const one = await loadPackage(packages, "jolt-physics");
  const jolt = await one.module({ print: console.error, printErr: console.error });
  await serve(joltRival(jolt, one, fileURLToPath(new URL(".", import.meta.url))));
}
