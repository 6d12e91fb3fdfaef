// Shapes of a scene as Rapier's. Conventions:
// - Capsules and cylinders lie along y in Rapier and along z in the scene: colliders are turned by 90 degrees about x.
// - A plane is a half-space at rest in world axes. Rectangles and meshes are triangles without an inside: fixed ones only.
// - Colliders have no density: mass is the body's. Points are kept in float; a hull keeps those of them that are corners.
import { length, plus, product, scaled, toWorld } from "../node/rotation.mjs";
import { Refusal, hasShape } from "../node/scene.mjs";

const vector = ([x, y, z]) => ({ x, y, z });
const yToZ = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];

/** Why a body's shape is refused; empty: it is not. */
export function refusedShape(body) {
  for (const kind of ["mesh", "rectangle"])
    if (!body.fixed && body.shape?.[kind]) return `a ${kind} of Rapier has no inside and must be fixed: \`${body.name}\``;
  return "";
}

const triangles = (rapier, points, corners, flags) =>
  rapier.ColliderDesc.trimesh(new Float32Array(points.flat()), new Uint32Array(corners.flat()), flags);

/** [{description, p_B, q_B}]: the colliders of a body, where they are in its axes. */
export function collidersOf(rapier, body, settings) {
  const { ColliderDesc } = rapier,
    at = { p_B: [0, 0, 0], q_B: [1, 0, 0, 0] };
  if (!hasShape(body)) return [];
  const [[kind, shape]] = Object.entries(body.shape);
  const flags = settings.smooth_inner_edges ? rapier.TriMeshFlags.FIX_INTERNAL_EDGES : undefined;
  switch (kind) {
    case "sphere":
      return [{ ...at, description: ColliderDesc.ball(shape.radius_m) }];
    case "box":
      return [{ ...at, description: ColliderDesc.cuboid(...shape.half_extents_m) }];
    case "plane": {
      const norm = length(shape.normal),
        normal = scaled(1 / norm, shape.normal);
      const description = new ColliderDesc(new rapier.HalfSpace(vector(normal)));
      return [{ ...at, p_B: scaled((shape.offset_m ?? 0) / norm, normal), description }];
    }
    case "capsule":
      return [{ ...at, q_B: yToZ, description: ColliderDesc.capsule(shape.half_length_m, shape.radius_m) }];
    case "cylinder":
      return [{ ...at, q_B: yToZ, description: ColliderDesc.cylinder(shape.half_length_m, shape.radius_m) }];
    case "convex": {
      const description = ColliderDesc.convexHull(new Float32Array(shape.points_m.flat())),
        hull = description.shape.intoRaw(); // the world makes another; undefined where Rapier finds none
      if (!hull)
        throw new Refusal(`rapier finds no hull of the points of \`${body.name}\`: they are in a line, or nearly, or too close together`);
      hull.free();
      return [{ ...at, description }];
    }
    case "rectangle": {
      const [a, b] = shape.half_extents_m;
      return [
        {
          ...at,
          description: triangles(
            rapier,
            [
              [-a, -b, 0],
              [a, -b, 0],
              [a, b, 0],
              [-a, b, 0],
            ],
            [
              [0, 1, 2],
              [0, 2, 3],
            ],
            flags,
          ),
        },
      ];
    }
    case "mesh":
      if (shape.triangles.length === 0) throw new Refusal(`rapier has no mesh without triangles: \`${body.name}\``);
      return [{ ...at, description: triangles(rapier, shape.points_m, shape.triangles, flags) }];
    case "compound":
      return shape.boxes.map((box) => ({
        p_B: box.position_body_m,
        q_B: box.orientation_wxyz,
        description: ColliderDesc.cuboid(...box.half_extents_m),
      }));
    default:
      throw new Refusal(`rapier's adapter has no shape \`${kind}\``);
  }
}

/** The pose of a collider in world axes for the pose of its body. */
export const posedAt = ({ p_B, q_B }, p_WB, q_WB) => ({ p: plus(p_WB, toWorld(q_WB, p_B)), q: product(q_WB, q_B) });
