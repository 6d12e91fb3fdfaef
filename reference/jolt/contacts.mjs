// Contact queries of Jolt (node/contacts.mjs): the manifolds of a step that is too short to move the bodies. A point's place is
// half way between those on the two shapes, its gap is their distance along the manifold's normal.
import { dot, minus, plus, scaled } from "../node/rotation.mjs";
import { JoltWorld, array } from "./world.mjs";

class StillWorld extends JoltWorld {
  found = [];

  note(a, b, manifold) {
    const normal = array(manifold.mWorldSpaceNormal),
      points = manifold.mRelativeContactPointsOn1.size();
    for (let k = 0; k < points; ++k) {
      const one = array(manifold.GetWorldSpaceContactPointOn1(k)),
        other = array(manifold.GetWorldSpaceContactPointOn2(k));
      this.found.push({
        body_a: a,
        body_b: b,
        x_m: scaled(0.5, plus(one, other)),
        normal,
        gap_m: dot(minus(other, one), normal),
      });
    }
  }
}

/** Where bodies at rest overlap, or nearly. */
export function overlaps(jolt, scene, settings) {
  const world = new StillWorld(jolt, scene, settings, true);
  try {
    world.step(1e-6, []);
    return world.found;
  } finally {
    world.free();
  }
}
