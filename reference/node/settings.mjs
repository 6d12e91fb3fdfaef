// Method ids, <engine>/<scheme>[:rtol[,atol]][+<response>][@<scalar>][{setting=value,...}], and the settings in them.
import { Refusal } from "./scene.mjs";

/** A JSON number that Atwood reads as a real one: a whole value is written 1.0. */
export class Real {
  constructor(value) {
    this.value = value;
  }
  toJSON() {
    if (!Number.isFinite(this.value)) return this.value > 0 ? "inf" : "-inf";
    return `@real:${this.value}`;
  }
}

/** JSON text in which every Real is a number with a point or an exponent. */
export const jsonText = (value) =>
  JSON.stringify(value).replace(/"@real:([^"]*)"/g, (_, text) => (/[.e]/.test(text) ? text : `${text}.0`));

/** @returns {{engine, scheme, tolerance, response, scalar, overrides}} overrides: text by name */
export function parseMethodId(text) {
  const parts = /^([^/:+@{]+)\/([^:+@{]+)(?::([^+@{]+))?(?:\+([^@{]+))?(?:@([^{]+))?(?:\{(.*)\})?$/s.exec(text);
  if (!parts) throw new Refusal(`no method \`${text}\``);
  const [, engine, scheme, tolerance, response, scalar, list] = parts,
    overrides = {};
  for (const [, name, quoted, plain] of (list ?? "").matchAll(/([^=,]+)=(?:"((?:[^"\\]|\\.)*)"|([^,]*))(?:,|$)/gs))
    overrides[name] = quoted === undefined ? plain : quoted.replace(/\\(.)/gs, "$1");
  return { engine, scheme, tolerance, response, scalar, overrides };
}

/** What a setting is in `settings` and `setting_rules` of hello. A setting: {name, value, doc, unit, real, least, ...}. */
export function describeSettings(settings) {
  const values = {},
    rules = {};
  for (const { name, value, real, printed, ...rule } of settings) {
    values[name] = real ? new Real(value) : value;
    if (printed && typeof value === "number") rule.least = rule.most = value;
    else if (printed) rule.choices = [value];
    for (const bound of ["least", "most"]) if (real && bound in rule) rule[bound] = new Real(rule[bound]);
    rules[name] = { unit: "", ...rule };
  }
  return { settings: values, setting_rules: rules };
}

function outside(setting, value) {
  const { least = -Infinity, most = Infinity, least_excluded, most_excluded, choices } = setting;
  if (choices) return !choices.includes(value);
  if (typeof value !== "number") return false;
  return (
    Number.isNaN(value) ||
    value < least ||
    value > most ||
    (least_excluded && value === least) ||
    (most_excluded && value === most)
  );
}

function valueOf(method, setting, given) {
  const wrong = (expected) => new Refusal(`${method}: \`${setting.name}\` is ${given}; expected ${expected}`);
  let value = given;
  if (typeof setting.value === "boolean") {
    if (!["true", "false"].includes(String(given))) throw wrong("true or false");
    value = String(given) === "true";
  } else if (typeof setting.value === "number") {
    value = String(given) === "inf" ? Infinity : Number(given);
    if (given === "" || Number.isNaN(value) || (!setting.real && !Number.isInteger(value)))
      throw wrong(setting.real ? "a number" : "a whole number");
  }
  if (setting.printed ? value !== setting.value : outside(setting, value)) {
    const range = setting.printed ? [setting.value] : setting.choices;
    throw wrong(range ? range.join(", ") : `${setting.least ?? "-inf"} to ${setting.most ?? "inf"}`);
  }
  return value;
}

/** The defaults of `table` with changes over them, each an object of values or their texts. Throws a Refusal. */
export function mergedSettings(method, table, ...changes) {
  const merged = Object.fromEntries(table.map((setting) => [setting.name, setting.value]));
  for (const [name, given] of changes.flatMap(Object.entries)) {
    const setting = table.find((each) => each.name === name);
    if (!setting) throw new Refusal(`${method} has no setting \`${name}\``);
    merged[name] = valueOf(method, setting, given);
  }
  return merged;
}
