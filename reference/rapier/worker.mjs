// Rapier as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: world.mjs.
import { fileURLToPath } from "node:url";
import { serve } from "../node/protocol.mjs";
import { rapierRival } from "./rapier.mjs";

/** Answers until standard input closes. `packages`: the folder that has node_modules. */
export async function main(packages) {
  const names = { standard: "@dimforge/rapier3d-compat", deterministic: "@dimforge/rapier3d-deterministic-compat" };
  await serve(rapierRival(packages, names, fileURLToPath(new URL(".", import.meta.url))));
}
