// Contact queries: where the bodies of a scene touch as they stand, by the collision detection of a stepped world. An engine
// answers them for the scene at rest, without forces, joints and laws. A contact's normal points from its first body to its
// second, a < b, and its depth is not negative.
import { Refusal, hasShape, readScene, refuseScene } from "./scene.mjs";
import { mergedSettings } from "./settings.mjs";

const LAW = { restitution: 0, friction: 0, rolling_friction_m: 0 };
const surface = (body) => ["plane", "rectangle", "mesh"].find((kind) => body.shape?.[kind]);

/** The bodies alone, at rest; a surface is fixed and all else is mobile: engines look for contacts of mobile bodies. */
function still(scene) {
  const bodies = scene.bodies.map((body) => ({
    ...body,
    fixed: Boolean(surface(body)) || !hasShape(body),
    mass_kg: 1,
    inertia_kg_m2: [1, 0, 0, 0, 1, 0, 0, 0, 1],
    velocity_m_per_s: [0, 0, 0],
    angular_velocity_body_rad_per_s: [0, 0, 0],
    release_s: 0,
    material: "any",
  }));
  const materials = [{ name: "any", ...LAW }],
    pairs = [{ between: ["any", "any"], ...LAW }];
  return readScene({ problem: scene.problem, gravity_m_per_s2: [0, 0, 0], bodies, materials, pairs });
}

function refuseSurfaces(engine, bodies) {
  const surfaces = bodies.filter(surface),
    mobile = surfaces.find((body) => !body.fixed);
  if (mobile && surfaces.length > 1)
    throw new Refusal(
      `${engine} has no contacts of two surfaces: \`${mobile.name}\` is a mobile ${surface(mobile)} beside another surface`,
    );
}

const noSweep = ({ name }) => new Refusal(`${name}'s adapter asks for contacts of bodies at rest: no sweeps in time`);

/** Sweeps of poses are refused: those of bodies at rest are asked for one pose after another. */
export function refuseSweep(rival, request) {
  throw request.swept ? noSweep(rival) : new Refusal(`${rival.name}'s adapter generates no poses of a sweep`);
}

/**
 * {contacts: [[a, b, x, y, z, nx, ny, nz, depth_m], ...]} of a request. `rival.overlaps(scene, settings)` gives contact points
 * {body_a, body_b, x_m, normal, gap_m} of all pairs near each other, as touches() of a world has them.
 */
export async function askContacts(rival, request) {
  if (!rival.overlaps) throw new Refusal(`${rival.name} answers no questions about contacts`);
  if (request.test && request.test !== "contacts")
    throw new Refusal(`${rival.name} has no test \`${request.test}\` of contacts`);
  if (request.swept) throw noSweep(rival);
  const { bodies } = request.scene,
    scene = still(request.scene),
    settings = mergedSettings(`${rival.name}/contacts`, rival.settings);
  refuseSurfaces(rival.name, bodies);
  refuseScene(rival.name, rival.scalar, scene);
  const reason = rival.refusal(scene, settings);
  if (reason) throw new Refusal(reason);
  await rival.prepare?.(settings);
  const found = rival.overlaps(scene, settings).filter((one) => one.gap_m <= 0);
  const asked = found.filter(({ body_a, body_b }) => !(bodies[body_a].fixed && bodies[body_b].fixed));
  return {
    contacts: asked.map(({ body_a, body_b, x_m, normal, gap_m }) => [body_a, body_b, ...x_m, ...normal, Math.abs(gap_m)]),
  };
}
