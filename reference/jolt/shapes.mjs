// Shapes of a scene in Jolt. Conventions:
// - extents are half extents, in float; capsules and cylinders lie along y and are turned to the scene's z;
// - boxes, cylinders and hulls are rounded by a convex radius inside their extents;
// - Jolt's shapes have a centre of mass of their own: it is moved to the body's origin, which is the scene's;
// - planes and meshes are of fixed bodies. A plane is a square about the point nearest the origin, PLANE_HALF_EXTENT_M wide
//   each way; a mesh has one side, that from which its triangles run anticlockwise.
import { length, scaled } from "../node/rotation.mjs";
import { Refusal } from "../node/scene.mjs";

export const PLANE_HALF_EXTENT_M = 1e4;
const TURN_Y_TO_Z = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];

export class Shapes {
  constructor(jolt, settings, memory) {
    Object.assign(this, { jolt, settings, memory });
  }

  /** A Shape of what `settings` (ShapeSettings) describe. */
  created(settings, body) {
    const result = this.memory.counted(settings).Create();
    if (result.HasError()) throw new Refusal(`jolt: the shape of \`${body.name}\`: ${result.GetError().c_str()}`);
    return this.memory.counted(result.Get());
  }
  radius(...extents_m) {
    return Math.min(this.settings.convex_radius_m, 0.1 * Math.min(...extents_m));
  }
  box(half_extents_m) {
    return new this.jolt.BoxShapeSettings(this.memory.vector(half_extents_m), this.radius(...half_extents_m));
  }
  turned(settings) {
    const { jolt, memory } = this;
    return new jolt.RotatedTranslatedShapeSettings(memory.vector([0, 0, 0]), memory.quaternion(TURN_Y_TO_Z), settings);
  }

  plane({ normal, offset_m }) {
    const norm = length(normal);
    const plane = this.memory.own(new this.jolt.Plane(this.memory.vector(scaled(1 / norm, normal)), -offset_m / norm));
    return new this.jolt.PlaneShapeSettings(plane, null, PLANE_HALF_EXTENT_M);
  }
  mesh(points_m, triangles) {
    const { jolt, memory } = this,
      list = memory.own(new jolt.TriangleList());
    for (const corners of triangles)
      list.push_back(memory.own(new jolt.Triangle(...corners.map((k) => memory.vector(points_m[k])))));
    return new jolt.MeshShapeSettings(list);
  }
  rectangle({ half_extents_m: [a, b] }) {
    return this.mesh(
      [
        [-a, -b, 0],
        [a, -b, 0],
        [a, b, 0],
        [-a, b, 0],
      ],
      [
        [0, 1, 2],
        [0, 2, 3],
        [0, 2, 1],
        [0, 3, 2],
      ],
    );
  }
  convex({ points_m }) {
    const made = new this.jolt.ConvexHullShapeSettings();
    for (const point of points_m) made.mPoints.push_back(this.memory.vector(point));
    const reach = points_m.map(length).reduce((a, b) => Math.max(a, b), 0);
    made.mMaxConvexRadius = this.radius(reach);
    return made;
  }
  compound({ boxes }) {
    const made = new this.jolt.StaticCompoundShapeSettings();
    for (const part of boxes)
      made.AddShapeShapeSettings(
        this.memory.vector(part.position_body_m),
        this.memory.quaternion(part.orientation_wxyz),
        this.box(part.half_extents_m),
        0,
      );
    return made;
  }

  settingsOf({ sphere, plane, rectangle, box, capsule, cylinder, convex, mesh, compound }) {
    const { jolt } = this;
    if (sphere) return new jolt.SphereShapeSettings(sphere.radius_m);
    if (plane) return this.plane(plane);
    if (rectangle) return this.rectangle(rectangle);
    if (box) return this.box(box.half_extents_m);
    if (capsule) return this.turned(new jolt.CapsuleShapeSettings(capsule.half_length_m, capsule.radius_m));
    if (cylinder) {
      const { radius_m: r, half_length_m: l } = cylinder;
      return this.turned(new jolt.CylinderShapeSettings(l, r, this.radius(r, l)));
    }
    if (convex) return this.convex(convex);
    if (mesh) return this.mesh(mesh.points_m, mesh.triangles);
    return this.compound(compound);
  }

  centred(shape, offset) {
    return this.memory.counted(new this.jolt.OffsetCenterOfMassShape(shape, this.memory.vector(offset)));
  }

  /** The body's Shape with its centre of mass at the origin; a small sphere for a body without one. */
  of(body) {
    if (Object.keys(body.shape ?? {}).length === 0) return this.created(new this.jolt.SphereShapeSettings(1e-3), body);
    const shape = this.created(this.settingsOf(body.shape), body);
    if (body.shape.plane || body.shape.mesh || body.shape.rectangle) return shape;
    const c = shape.GetCenterOfMass(),
      center = [c.GetX(), c.GetY(), c.GetZ()];
    return length(center) === 0 ? shape : this.centred(shape, scaled(-1, center));
  }
}

/** Why Jolt cannot represent a body's shape; empty when it can. */
export function refusedShape(body) {
  const fixedOnly = ["mesh", "rectangle"].find((kind) => body.shape?.[kind]);
  return fixedOnly && !body.fixed
    ? `Jolt's ${fixedOnly === "mesh" ? "mesh" : "rectangle (two triangles)"} must be fixed: \`${body.name}\``
    : "";
}
