// Rapier 0.21 as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: world.mjs.
import { fileURLToPath } from "node:url";
import { loadPackage } from "../node/packages.mjs";
import { serve } from "../node/protocol.mjs";
import { rapierRival } from "./rapier.mjs";

/** `packages`: the folder that has node_modules. `build`: "rapier3d-compat" or "rapier3d-deterministic-compat". */
export async function main(packages) {
  const one = await loadPackage(packages, "@dimforge/rapier3d-compat");
  await one.module.init();
  await serve(rapierRival(one, fileURLToPath(new URL(".", import.meta.url))));
}
