// The description of a rival engine by its adapter, and the engine made from it: refusals, presets, settings, the run.
//
// A rival is an object with
//   name, version, scalar ("float" or "double"), source
//   settings    [{name, value, doc, unit, real, least, most, least_excluded, most_excluded, choices, printed}]; `real`: a
//               number that need not be whole; `printed`: shown and not to be set; one is "substeps"
//   presets     [{scheme, doc, changes, byClass, claims}]; byClass: changed by the class of the scene, as tuned
//   refusal(scene, settings)         why the engine cannot represent the scene, beyond the refusals of every adapter
//   make(scene, settings, observe)   a world (run.mjs); throws a Refusal where the engine itself refuses the scene
//   emptyStep(settings)              a function that steps a world without bodies once, which is what a call costs; its
//                                    member free(), where it has one, gives that world's memory back
//   prepare(settings)                optional: awaited ahead of make(), where a part of the engine is loaded on demand
//   joints      whether it takes joints
//   overlaps(scene, settings)        optional: contact points of a scene at rest, for contact queries (contacts.mjs)
//   files       paths of the engine's own files, whose bytes decide its results
import { readFileSync } from "node:fs";
import { Refusal, conventionNote, readScene, refuseScene } from "./scene.mjs";
import { describeSettings, mergedSettings, parseMethodId } from "./settings.mjs";
import { sceneClass } from "./scene_class.mjs";
import { runWorld } from "./run.mjs";

export const substepsSetting = {
  name: "substeps",
  value: 1,
  least: 1,
  most: 1000,
  doc: "Inner steps of a step, all of one length.",
};
const classes = ["free-flight", "bounce", "friction", "stack", "heap", "mechanism"];
const tuned = JSON.parse(readFileSync(new URL("../rivals/tuned.json", import.meta.url), "utf8"));

/** What `atwood tune` found for an engine and a class of scenes, as changes of its defaults. */
const tunedChanges = (engine, sceneClass) => tuned[engine]?.[sceneClass]?.settings ?? {};

/** What every rival's rows print beside its own settings. */
const printedOf = (rival) => [
  { name: "scalar", value: rival.scalar, printed: true, doc: "Type of the engine's numbers." },
  { name: "units", value: "m, kg, s, rad: the scene's, nothing is scaled", printed: true, doc: "Units of the engine's world." },
];

function settingsTable(rival, preset) {
  const table = [...rival.settings, ...printedOf(rival)].map((setting) =>
    setting.name in (preset.changes ?? {}) ? { ...setting, value: preset.changes[setting.name] } : setting,
  );
  for (const each of preset.byClass ? classes : []) {
    const words = Object.entries(tunedChanges(rival.name, each))
      .map(([name, value]) => `${name}=${value}`)
      .join(", ");
    table.push({
      name: `class_${each}`,
      value: words || "the default",
      printed: true,
      doc: "Changes of the defaults in scenes of this class.",
    });
  }
  return table;
}

const describe = (rival, preset) => ({
  id: `${rival.name}/${preset.scheme}`,
  doc: preset.doc,
  source: rival.source,
  claims: preset.claims ?? {},
  ...describeSettings(settingsTable(rival, preset)),
});

/** The members of hello that are the engine's. */
export const describeRival = (rival) => ({
  engine: rival.name,
  version: rival.version,
  scalar: rival.scalar,
  frames: true,
  joints: Boolean(rival.joints),
  methods: rival.presets.map((preset) => describe(rival, preset)),
});

function settingsOf(rival, id, scene) {
  const preset = rival.presets.find((each) => each.scheme === id.scheme);
  if (id.engine !== rival.name || !preset)
    throw new Refusal(
      `${rival.name} offers ${rival.presets.map((each) => each.scheme).join(", ")}, not ${id.engine}/${id.scheme}`,
    );
  if (id.tolerance) throw new Refusal(`${rival.name} has no error control: expected a method without a tolerance`);
  if (id.response) throw new Refusal(`${rival.name} has its own contact response: +${id.response} is not available`);
  if (id.scalar && id.scalar !== rival.scalar)
    throw new Refusal(`${rival.name} computes in ${rival.scalar}; found the scalar \`${id.scalar}\``);
  const ofClass = preset.byClass ? tunedChanges(rival.name, sceneClass(scene)) : {};
  return mergedSettings(`${rival.name}/${preset.scheme}`, settingsTable(rival, preset), ofClass, id.overrides);
}

/** Nanoseconds of a step of a world without bodies: the median of 11 times the mean of 200. */
function emptyStepTime(step) {
  const means = [];
  for (let k = 0; k < 12; ++k) {
    const start = process.hrtime.bigint();
    for (let i = 0; i < 200; ++i) step();
    if (k > 0) means.push(Number(process.hrtime.bigint() - start) / 200);
  }
  step.free?.();
  return Math.max(1, Math.round(means.sort((a, b) => a - b)[5]));
}

/** The outcome of a run request. */
export async function runRival(rival, request, put) {
  const id = parseMethodId(request.method),
    scene = readScene(request.scene),
    settings = settingsOf(rival, id, scene);
  refuseScene(rival.name, rival.scalar, scene);
  if (!rival.joints && (scene.joints.length > 0 || scene.ropes.length > 0))
    throw new Refusal(`${rival.name}'s adapter takes no joints or ropes`);
  const reason = rival.refusal(scene, settings);
  if (reason) throw new Refusal(reason);
  await rival.prepare?.(settings);
  const done = runWorld((observe) => rival.make(scene, settings, observe), scene, request, settings.substeps, put);
  const note = conventionNote(rival.name, scene);
  if (note) done.reason = done.reason ? `${done.reason}; ${note}` : note;
  if (done.status === "ok" && request.pass === "timing")
    done.call_ns = emptyStepTime(rival.emptyStep(settings)) * settings.substeps;
  return done;
}
