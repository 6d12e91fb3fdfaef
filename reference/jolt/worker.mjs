// Jolt as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: world.mjs, shapes.mjs, joints.mjs.
import { fileURLToPath } from "node:url";
import { serve } from "../node/protocol.mjs";
import { joltRival } from "./jolt.mjs";

/** Answers until standard input closes. `packages`: the folder that has node_modules. */
export async function main(packages) {
  await serve(joltRival(packages, fileURLToPath(new URL(".", import.meta.url))));
}
