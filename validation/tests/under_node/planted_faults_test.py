"""Tests of the adapters under Node.js are seen to fail: each fault is planted in a copy of the sources, and the test that is to
find it must fail there. What validation/tests/mutants does for C++. planted_faults_test.py BIN_DIR ROOT; engines that are not
built are left out."""
import collections
import os
import shutil
import subprocess
import sys
import tempfile

BIN_DIR, ROOT = (os.path.abspath(path) for path in sys.argv[1:3])
TESTS = os.path.join(ROOT, "validation/tests/under_node")
Fault = collections.namedtuple("Fault", "engine file before after test")  # test: a suite's file, then a part of the test's name

RATE = "w_WB_B: toBody(q_WB, array(body.{}()))"
SPIN = "vector(toWorld(body.orientation_wxyz, body.angular_velocity_body_rad_per_s))"
FAULTS = [
    # frames of rates, of inertia and of forces
    Fault("jolt", "jolt/world.mjs", RATE.format("GetAngularVelocity"), "w_WB_B: array(body.GetAngularVelocity())", "conventions rates_are_of"),
    Fault("jolt", "jolt/world.mjs", SPIN, "vector(body.angular_velocity_body_rad_per_s)", "conventions rates_are_of"),
    Fault("jolt", "jolt/world.mjs", "this.memory.quaternion(q_BP)", "this.memory.quaternion([1, 0, 0, 0])", "conventions force_at_a_point"),
    Fault("rapier", "rapier/world.mjs", RATE.format("angvel"), "w_WB_B: array(body.angvel())", "rapier rates_are_of"),
    Fault("rapier", "rapier/world.mjs", SPIN, "vector(body.angular_velocity_body_rad_per_s)", "rapier rates_are_of"),
    Fault("rapier", "rapier/world.mjs", "rotation(q_BP)", "rotation([1, 0, 0, 0])", "rapier inertia_is_in"),
    Fault("mujoco3", "mujoco3/model.mjs", 'quat="${text(q_BP)}" ', "", "conventions force_at_a_point"),
    Fault("mujoco3", "mujoco3/world.mjs", "w_WB_B: three(qvel, v + 3)", "w_WB_B: toWorld([qpos[q + 3], ...three(qpos, q + 4)], three(qvel, v + 3))",
          "conventions rates_are_of"),
    Fault("rapier", "node/forces.mjs", "cross(toWorld(this.motions[i].q_WB, point_B), force_N)", "cross(point_B, force_N)",
          "rapier force_at_a_point"),
    Fault("mujoco3", "node/forces.mjs", "toWorld(sum.motions[i].q_WB, f.direction_body)", "f.direction_body", "conventions thruster"),
    # the bound of a damper: with the inertia of free bodies
    Fault("jolt", "node/explicit_dampers.mjs", "left[k] -= share * x", "left[k] -= 0 * share * x", "conventions damper_beyond"),
    # axes of shapes
    Fault("jolt", "jolt/shapes.mjs", "return this.turned(new jolt.CapsuleShapeSettings(capsule.half_length_m, capsule.radius_m));",
          "return new jolt.CapsuleShapeSettings(capsule.half_length_m, capsule.radius_m);", "conventions shapes_stand"),
    Fault("rapier", "rapier/colliders.mjs", "yToZ = [Math.SQRT1_2, Math.SQRT1_2, 0, 0]", "yToZ = [1, 0, 0, 0]", "rapier lie_along_z"),
    Fault("mujoco3", "mujoco3/model.mjs", "attitude = fromZ(n);", "attitude = body.orientation_wxyz;", "contacts plane_stands"),
    # contacts: from the first body to the second, whichever way round the engine has them
    Fault("jolt", "jolt/contacts.mjs", "        normal,\n", "        normal: scaled(-1, normal),\n", "contacts whichever_comes_first"),
    Fault("jolt", "jolt/world.mjs", "normal: array(manifold.mWorldSpaceNormal)", "normal: scaled(-1, array(manifold.mWorldSpaceNormal))",
          "conventions along_the_normal"),
    Fault("jolt", "jolt/world.mjs", "decides === b ? 1 : -1", "1", "conventions along_the_normal"),
    Fault("rapier", "rapier/world.mjs", "sign = a < b ? 1 : -1", "sign = 1", "rapier other_way_round"),
    Fault("rapier", "rapier/world.mjs", "flipped ? [other, one] : [one, other]", "[one, other]", "rapier other_way_round"),
    Fault("mujoco3", "mujoco3/world.mjs", "scaled(first < second ? 1 : -1, three(contact.frame))", "three(contact.frame)",
          "contacts whichever_comes_first"),
    Fault("mujoco3", "mujoco3/world.mjs", "toB = first < second ? 1 : -1", "toB = 1", "conventions along_the_normal"),
    # laws of pairs
    Fault("jolt", "jolt/world.mjs", "combined.mCombinedFriction = own.friction", "combined.mCombinedFriction = own.restitution",
          "conventions friction_is"),
    Fault("jolt", "jolt/world.mjs", "combined.mCombinedRestitution = own.restitution", "combined.mCombinedRestitution = 0.5",
          "conventions law_is_the_pair"),
    Fault("rapier", "rapier/coefficients.mjs", "filter: [...all].reduce((bits, b) => bits | bit(b), 0)", "filter: 0xffff", "rapier in_one_layer"),
    Fault("rapier", "rapier/coefficients.mjs", "partnersOf(layer, others, own), used)", "partnersOf(layer, others, own), 0)",
          "rapier in_one_layer"),
    Fault("rapier", "rapier/coefficients.mjs", "if (!others.some(([i, j]) => i === a && j === a)) put(a, a);", "put(a, a);",
          "rapier in_one_layer"),
    Fault("rapier", "rapier/coefficients.mjs", "{ ...rulesOf(count, layer), groups }", "{ ...rulesOf(count, [layer[0]]), groups }",
          "rapier no_rule_combines"),
    Fault("jolt", "jolt/world.mjs", "body.SetFriction(law.friction)", "body.SetFriction(law.restitution)", "conventions oblique_bounce"),
    Fault("rapier", "rapier/world.mjs", "description.setFriction(friction.values[material])", "description.setFriction(restitution.values[material])",
          "rapier oblique_bounce"),
    # damping and integrators
    Fault("mujoco3", "node/forces.mjs", "along = l > 0 ? f.stiffness_N_per_m * (l - (f.rest_length_m ?? 0))", "along = l > 0 ? f.stiffness_N_per_m * l * l",
          "conventions constant_over_a_step"),
    Fault("jolt", "jolt/settings.mjs", '"linear_damping_per_s", 0', '"linear_damping_per_s", 0.05', "conventions nothing_is_damped"),
]


def copied(folder, fault):
    """Sources with the fault, and a folder of the engine's script."""
    shutil.copytree(os.path.join(ROOT, "reference"), os.path.join(folder, "reference"),
                    ignore=lambda at, names: [name for name in names if not name.endswith((".mjs", ".json"))
                                              and not os.path.isdir(os.path.join(at, name))])
    path = os.path.join(folder, "reference", fault.file)
    with open(path) as file:
        text = file.read()
    if text.count(fault.before) != 1:
        raise SystemExit(f"{fault.file} has {text.count(fault.before)} times what the fault replaces: {fault.before}")
    with open(path, "w") as file:
        file.write(text.replace(fault.before, fault.after))
    with open(os.path.join(BIN_DIR, f"atwood-{fault.engine}")) as file:
        script = file.read()
    programs = os.path.join(folder, "bin")
    os.mkdir(programs)
    with open(os.path.join(programs, f"atwood-{fault.engine}"), "w") as file:
        file.write(script.replace(f"{ROOT}/reference/", f"{folder}/reference/"))
    os.chmod(file.name, 0o755)
    return programs


def found(fault):
    """What the test says of the copy with the fault: empty where it does not notice."""
    suite, name = fault.test.split()
    with tempfile.TemporaryDirectory() as folder:
        programs = copied(folder, fault)
        shutil.copytree(TESTS, os.path.join(folder, "validation/tests/under_node"))
        command = [sys.executable, os.path.join(folder, f"validation/tests/under_node/{suite}_test.py"), programs]
        ended = subprocess.run([*command, *([] if suite == "rapier" else [fault.engine]), "-k", name], text=True, capture_output=True,
                               timeout=600)
    if "Ran 1 test" not in ended.stderr:
        raise SystemExit(f"{suite}: no one test of the name {name}: {ended.stderr or ended.stdout}")
    ran = "crashed" not in ended.stderr and "ended with exit code" not in ended.stderr  # the figure is wrong, not the syntax
    return ran and "AssertionError" in ended.stderr and ended.returncode == 1


faults = [fault for fault in FAULTS if os.path.exists(os.path.join(BIN_DIR, f"atwood-{fault.engine}"))]
if not faults:
    print("none of the engines is built")
    sys.exit(77)
unseen = [fault for fault in faults if not found(fault)]
for fault in unseen:
    print(f"{fault.test} does not notice, in {fault.file}: {fault.before} -> {fault.after}")
print(f"{len(faults)} faults, {len(unseen)} not noticed")
sys.exit(bool(unseen))
