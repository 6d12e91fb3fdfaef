// MuJoCo 3 as a worker of Atwood's protocol (reference/your_engine/README.md). Conventions: model.mjs, world.mjs.
import { fileURLToPath } from "node:url";
import { loadPackage } from "../node/packages.mjs";
import { serve } from "../node/protocol.mjs";
import { mujocoRival } from "./mujoco3.mjs";

/** `packages`: the folder that has node_modules. */
export async function main(packages) {
  const one = await loadPackage(packages, "@mujoco/mujoco");
  const mujoco = await one.module({ print: console.error, printErr: console.error });
  await serve(mujocoRival(mujoco, one, fileURLToPath(new URL(".", import.meta.url))));
}
