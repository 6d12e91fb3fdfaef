// The class of a scene, by which `tuned` chooses its settings: the rules of reference/rivals/scene_class.hpp. Whether two
// bodies touch is exact for two spheres, two boxes and a plane; bounding spheres say it for other pairs.
import { cross, dot, length, minus, scaled, toBody, toWorld } from "./rotation.mjs";
import { hasShape, lawsInPlay, shapesMatter } from "./scene.mjs";

const MOST_IN_STACK = 128;
const FEWEST_IN_HEAP = 16;
const TOUCHING = 1e-3; // of the smaller body's radius

function farthest(points) {
  return points.reduce((most, point) => Math.max(most, length(point)), 0);
}

function boundingRadius({ sphere, plane, rectangle, box, capsule, cylinder, convex, mesh, compound }) {
  if (sphere) return sphere.radius_m;
  if (plane) return Infinity;
  if (rectangle) return Math.hypot(...rectangle.half_extents_m);
  if (box) return length(box.half_extents_m);
  if (capsule) return capsule.radius_m + capsule.half_length_m;
  if (cylinder) return Math.hypot(cylinder.radius_m, cylinder.half_length_m);
  if (convex || mesh) return farthest((convex ?? mesh).points_m);
  return Math.max(0, ...compound.boxes.map((part) => length(part.position_body_m) + length(part.half_extents_m)));
}

const boxReach = (n, [a, b, c]) => a * Math.abs(n[0]) + b * Math.abs(n[1]) + c * Math.abs(n[2]);

/** How far a shape reaches from its body's origin along a unit vector in body axes. */
function reach(n, shape) {
  const { sphere, rectangle, box, capsule, cylinder, convex, mesh, compound } = shape;
  if (sphere) return sphere.radius_m;
  if (box) return boxReach(n, box.half_extents_m);
  if (rectangle) return boxReach(n, [...rectangle.half_extents_m, 0]);
  if (capsule) return capsule.radius_m + capsule.half_length_m * Math.abs(n[2]);
  if (cylinder) return cylinder.radius_m * Math.hypot(n[0], n[1]) + cylinder.half_length_m * Math.abs(n[2]);
  if (convex || mesh) return (convex ?? mesh).points_m.reduce((most, p) => Math.max(most, dot(n, p)), -Infinity);
  const ofPart = ({ position_body_m: p, orientation_wxyz: q, half_extents_m }) =>
    dot(n, p) + boxReach(toBody(q, n), half_extents_m);
  return Math.max(...compound.boxes.map(ofPart));
}

/** Whether no axis keeps two boxes apart by more than near_m: normals of faces, and of pairs of edges. */
function boxesTouch(one, other, near_m) {
  const axesOf = (body) =>
    [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ].map((axis) => toWorld(body.orientation_wxyz, axis));
  const a = axesOf(one),
    b = axesOf(other),
    between = minus(other.position_m, one.position_m);
  const edges = a.flatMap((u) => b.map((v) => cross(u, v))).filter((n) => length(n) > 1e-6);
  return [...a, ...b, ...edges.map((n) => scaled(1 / length(n), n))].every((n) => {
    const reaches = [one, other].map((body) => boxReach(toBody(body.orientation_wxyz, n), body.shape.box.half_extents_m));
    return Math.abs(dot(n, between)) - reaches[0] - reaches[1] <= near_m;
  });
}

function touch(one, other) {
  const r = boundingRadius(one.shape),
    s = boundingRadius(other.shape);
  const near_m = TOUCHING * Math.min(r, s);
  if (Number.isFinite(r) && Number.isFinite(s)) {
    const near = length(minus(one.position_m, other.position_m)) <= r + s + near_m;
    return near && (one.shape.box && other.shape.box ? boxesTouch(one, other, near_m) : true);
  }
  const [body, { plane }] = Number.isFinite(r) ? [one, other.shape] : [other, one.shape];
  if (body.shape.plane) return false;
  const norm = length(plane.normal),
    down = scaled(-1 / norm, plane.normal);
  return -dot(down, body.position_m) - plane.offset_m / norm - reach(toBody(body.orientation_wxyz, down), body.shape) <= near_m;
}

const still = (body) => length(body.velocity_m_per_s) === 0 && length(body.angular_velocity_body_rad_per_s) === 0;

/** "mechanism", "free-flight", "stack", "heap", "friction" or "bounce", of a scene (scene.mjs). */
export function sceneClass(scene) {
  if (scene.joints.length + scene.ropes.length > 0) return "mechanism";
  if (!shapesMatter(scene)) return "free-flight";
  const shaped = scene.bodies.filter(hasShape),
    fixed = shaped.filter((body) => body.fixed);
  const movable = shaped.filter((body) => !body.fixed),
    count = movable.length,
    laws = lawsInPlay(scene);
  const gravity = length(scene.gravity_m_per_s2) > 0;
  if (count > MOST_IN_STACK) return gravity ? "heap" : "bounce";
  const restitution = laws.some((law) => law.restitution > 0);
  const friction = laws.some((law) => law.friction > 0 || law.rolling_friction_m > 0);
  const touching = () => movable.some((a, i) => movable.slice(0, i).some((b) => touch(a, b)));
  if (count >= 2 && movable.every(still) && !restitution && touching()) return "stack";
  const grounded = movable.filter((a) => fixed.some((b) => touch(a, b))).length;
  if (gravity && count >= FEWEST_IN_HEAP && 2 * grounded < count) return "heap";
  return friction && grounded > 0 && 2 * grounded >= count ? "friction" : "bounce";
}
