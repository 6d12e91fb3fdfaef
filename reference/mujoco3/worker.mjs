// MuJoCo 3 as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: model.mjs, world.mjs.
import { fileURLToPath } from "node:url";
import { serve } from "../node/protocol.mjs";
import { mujocoRival } from "./mujoco3.mjs";

/** Answers until standard input closes. `packages`: the folder that has node_modules. */
export async function main(packages) {
  await serve(mujocoRival(packages, fileURLToPath(new URL(".", import.meta.url))));
}
