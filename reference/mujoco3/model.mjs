// A scene as the XML that MuJoCo compiles. Conventions of MuJoCo:
// - a body that rotates has a free joint (position and velocity in world axes, angular velocity in body axes), a point mass
//   has three slide joints along the world's axes;
// - body i of the scene is the <body> "b<i>": of the world, or of the parent of the joint that places it (mechanism.mjs);
// - quaternions are w, x, y, z; extents are half extents, the axis of a capsule and cylinder is z, and its half length
//   excludes the caps, as in the scene; a mesh collides as its convex hull;
// - the diagonal inertia is in a frame of its own (quat), that of the principal axes.
// - what is welded counts as one body where a parent and its child do not collide: that filter is off, and joined bodies are
//   listed.
import { joined } from "../node/joints.mjs";
import { fromZ, length, principalAxes, scaled, toBody } from "../node/rotation.mjs";
import { hasShape, rotates, shapesMatter } from "../node/scene.mjs";
import { constraintElements, excludedPairs, jointElements, placementAtZero, placingJoints, ropeSites } from "./mechanism.mjs";
import { precedences } from "./pair_laws.mjs";

const text = (values) => values.join(" ");
const on = (flag) => (flag ? "enable" : "disable");
const dimension = ({ friction, rolling_friction_m }) => (rolling_friction_m > 0 ? 6 : friction > 0 ? 3 : 1);

function options(scene, s) {
  const tolerance = scene.joints.length + scene.ropes.length > 0 ? s.mechanism_tolerance : s.tolerance;
  return (
    `<option gravity="${text(scene.gravity_m_per_s2)}" integrator="${s.integrator}" cone="${s.cone}" solver="${s.solver}" ` +
    `jacobian="${s.jacobian}" iterations="${s.iterations}" tolerance="${tolerance}" ls_iterations="${s.ls_iterations}" ` +
    `ls_tolerance="${s.ls_tolerance}" noslip_iterations="${s.noslip_iterations}" noslip_tolerance="${s.noslip_tolerance}" ` +
    `impratio="${s.impratio}" ccd_iterations="${s.ccd_iterations}" ccd_tolerance="${s.ccd_tolerance}">\n` +
    `<flag warmstart="${on(s.warm_start)}" refsafe="${on(s.refsafe)}" multiccd="${on(s.multiccd)}" island="${on(s.islands)}" ` +
    `nativeccd="${on(s.nativeccd)}" eulerdamp="${on(s.eulerdamp)}" autoreset="disable" filterparent="disable"/>\n</option>\n`
  );
}

const softness = (s) =>
  `solref="${s.solref_time_constant_s} ${s.solref_damping_ratio}" solimp="${s.solimp_least} ${s.solimp_most} ` +
  `${s.solimp_width_m} ${s.solimp_midpoint} ${s.solimp_power}" margin="${s.margin_m}" gap="${s.gap_m}"`;

/** The <geom> elements of body i; `law`: attributes of its friction. */
function geoms(body, i, law) {
  const { sphere, plane, box, capsule, cylinder, convex, compound } = body.shape;
  const geom = (words) => `<geom name="g${i}" ${words}${law}/>`;
  if (sphere) return geom(`type="sphere" size="${sphere.radius_m}"`);
  if (plane) return geom('type="plane" size="0 0 1"');
  if (box) return geom(`type="box" size="${text(box.half_extents_m)}"`);
  if (capsule) return geom(`type="capsule" size="${capsule.radius_m} ${capsule.half_length_m}"`);
  if (cylinder) return geom(`type="cylinder" size="${cylinder.radius_m} ${cylinder.half_length_m}"`);
  if (convex) return geom(`type="mesh" mesh="m${i}"`);
  return (compound?.boxes ?? [])
    .map(
      (part) =>
        `<geom type="box" size="${text(part.half_extents_m)}" pos="${text(part.position_body_m)}" ` +
        `quat="${text(part.orientation_wxyz)}"${law}/>`,
    )
    .join("");
}

class Writer {
  constructor(scene, settings, held) {
    Object.assign(this, {
      scene,
      settings,
      held,
      order: precedences(scene),
      placing: placingJoints(scene),
      collide: shapesMatter(scene),
    });
    this.children = scene.bodies.map(() => []);
    scene.bodies.forEach((_, i) => this.parentOf(i) >= 0 && this.children[this.parentOf(i)].push(i));
  }

  /** The body of whose element this body's is a part; -1: the world's. */
  parentOf(i) {
    const parent = this.placing[i] < 0 ? -1 : this.scene.joints[this.placing[i]].parent;
    return parent < 0 || this.scene.bodies[parent].fixed ? -1 : parent;
  }

  write() {
    const { scene, settings } = this,
      words = softness(settings);
    const bodies = scene.bodies.map((_, i) => (this.parentOf(i) < 0 ? this.body(i) : "")).join("");
    return (
      `<mujoco>\n<compiler angle="radian" inertiafromgeom="false"/>\n${options(scene, settings)}` +
      `<default><geom ${words}/><pair ${words}/></default>\n<asset>\n${this.meshes()}</asset>\n` +
      `<worldbody>\n${ropeSites(scene, -1)}${bodies}</worldbody>\n` +
      `<contact>\n${this.collide ? excludedPairs(scene) : ""}${this.pairs()}</contact>\n` +
      `${constraintElements(scene, settings)}</mujoco>\n`
    );
  }

  meshes() {
    const points = (body) => body.shape.convex.points_m.map(text).join(" ");
    return this.scene.bodies
      .map((body, i) =>
        this.collide && body.shape?.convex ? `<mesh name="m${i}" inertia="convex" vertex="${points(body)}"/>\n` : "",
      )
      .join("");
  }

  body(i) {
    const { scene } = this,
      body = scene.bodies[i],
      plane = body.shape?.plane;
    let position = body.position_m,
      attitude = body.orientation_wxyz;
    if (plane) {
      // in world axes, for every pose of its body
      const n = scaled(1 / length(plane.normal), plane.normal);
      position = scaled(plane.offset_m / length(plane.normal), n);
      attitude = fromZ(n);
    }
    if (this.placing[i] >= 0) {
      const at = placementAtZero(scene, scene.joints[this.placing[i]]);
      position = at.p;
      attitude = at.q;
    }
    const moves = !body.fixed && !this.held[i],
      law = this.collide && hasShape(body) ? this.law(body) : "";
    return (
      `<body name="b${i}" pos="${text(position)}" quat="${text(attitude)}">${moves ? this.inertia(i) : ""}` +
      `${this.collide && hasShape(body) ? geoms(body, i, law) : ""}${ropeSites(scene, i)}` +
      `${this.children[i].map((child) => this.body(child)).join("")}</body>\n`
    );
  }

  law(body) {
    if (!this.order) return ' contype="0" conaffinity="0"';
    const law = this.order.get(body.material) ?? { priority: 0, friction: 0, rolling_friction_m: 0 };
    return ` priority="${law.priority}" condim="${dimension(law)}" friction="${law.friction} 0 ${law.rolling_friction_m}"`;
  }

  // A point mass that translates has slide joints along the world's axes, and any inertia. Below a turning body its own is
  // zero, which MuJoCo admits for bodies without joints.
  inertia(i) {
    const body = this.scene.bodies[i],
      placed = this.placing[i] >= 0;
    const joints = placed ? jointElements(this.scene, this.settings, this.placing[i]) : "";
    if (rotates(body)) {
      const { moments_kg_m2, q_BP } = principalAxes(body.inertia_kg_m2);
      return (
        `${joints}${placed ? "" : "<freejoint/>"}<inertial pos="0 0 0" mass="${body.mass_kg}" quat="${text(q_BP)}" ` +
        `diaginertia="${text(moments_kg_m2)}"/>`
      );
    }
    const slides = [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ]
      .map((axis) => `<joint type="slide" axis="${text(toBody(body.orientation_wxyz, axis))}"/>`)
      .join("");
    const welded = placed && this.scene.joints[this.placing[i]].kind === "fixed";
    return `${joints}${placed ? "" : slides}<inertial pos="0 0 0" mass="${body.mass_kg}" ` +
      `diaginertia="${welded ? "0 0 0" : "1 1 1"}"/>`;
  }

  /** An explicit list of pairs, where no order of materials says their laws. */
  pairs() {
    const { scene } = this;
    if (this.order || !this.collide) return "";
    const lines = [];
    scene.bodies.forEach((a, i) =>
      scene.bodies.slice(0, i).forEach((b, j) => {
        if (!hasShape(a) || !hasShape(b) || (a.fixed && b.fixed) || joined(scene, i, j)) return;
        const law = scene.pairLaw(j, i),
          { friction, rolling_friction_m } = law;
        lines.push(
          `<pair geom1="g${j}" geom2="g${i}" condim="${dimension(law)}" ` +
            `friction="${friction} ${friction} 0 ${rolling_friction_m} ${rolling_friction_m}"/>\n`,
        );
      }),
    );
    return lines.join("");
  }
}

/** The model's XML. `held[i]`: body i is at rest, also if the scene releases it later. */
export const xmlOf = (scene, settings, held) => new Writer(scene, settings, held).write();
