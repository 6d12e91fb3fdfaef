// Rapier combines the coefficients of two colliders: by their mean, the smaller, the larger, or the product. Here the law
// of every pair of materials in the scene is given, so that coefficients of the materials are looked for which, combined
// by one of these rules, give each pair its own. Where no rule does, the pairs are divided into layers: a body then has a
// collider in each layer of its material, and collision groups let each pair of materials meet in one layer.

/** In the order of RAPIER.CoefficientCombineRule, and what each does with two coefficients. */
const rules = [
  { rule: "Average", combine: (a, b) => (a + b) / 2 },
  { rule: "Max", combine: Math.max },
  { rule: "Min", combine: Math.min },
  { rule: "Multiply", combine: (a, b) => a * b },
];

/**
 * Coefficients under the mean: c_i + c_j = 2 e_ij along the pairs. In a connected group every coefficient is s x + d with
 * s = 1 or -1 and the first one x; a pair of two of the same s gives x, without such a pair it is free.
 */
function byMean(count, pairs) {
  const found = new Array(count).fill(undefined),
    terms = new Array(count).fill(undefined);
  for (const [first, , trial] of pairs) {
    if (terms[first]) continue;
    const group = [first];
    let x = trial;
    terms[first] = { s: 1, d: 0 };
    for (const i of group)
      for (const [a, b, e] of pairs) {
        if (a !== i && b !== i) continue;
        const j = a === i ? b : a;
        if (!terms[j]) {
          terms[j] = { s: -terms[i].s, d: 2 * e - terms[i].d };
          group.push(j);
        } else if (terms[i].s === terms[j].s) {
          x = (2 * e - terms[i].d - terms[j].d) / (2 * terms[i].s);
        }
      }
    for (const i of group) found[i] = terms[i].s * x + terms[i].d;
  }
  return found;
}

const extreme = (count, pairs, pick) => {
  const found = new Array(count).fill(undefined);
  for (const [a, b, e] of pairs) for (const i of [a, b]) found[i] = found[i] === undefined ? e : pick(found[i], e);
  return found;
};

/** Coefficients under the product: those under the mean of the logarithms. */
function byProduct(count, pairs) {
  const loose = pairs.filter(([, , e]) => e === 0);
  const found = byMean(
    count,
    pairs.filter(([, , e]) => e > 0).map(([a, b, e]) => [a, b, Math.log(e) / 2]),
  ).map((x) => (x === undefined ? undefined : Math.exp(x)));
  for (const [a, b] of loose) for (const i of [b, a]) if (found[i] === undefined) found[i] = 0;
  return found;
}

const solvers = {
  Average: byMean,
  Max: (n, p) => extreme(n, p, Math.min),
  Min: (n, p) => extreme(n, p, Math.max),
  Multiply: byProduct,
};

/**
 * Coefficients of `count` materials, for pairs [i, j, coefficient] of them: {rule, values}, or null where no rule gives
 * every pair its own to 1e-6 of it.
 */
export function coefficientsOf(count, pairs) {
  for (const { rule, combine } of rules) {
    const values = solvers[rule](count, pairs).map((value) => value ?? 0);
    const exact = pairs.every(([a, b, e]) => Math.abs(combine(values[a], values[b]) - e) <= 1e-6 * e);
    if (exact && values.every((value) => value >= 0)) return { rule, values };
  }
  return null;
}

const MOST_GROUPS = 16; // Rapier's
const MOST_MATERIALS = 32; // in scenes that need layers: the search for them grows with the fifth power

/** Rules and values for these pairs [i, j, law]: {restitution, friction}; null where there are none. */
function rulesOf(count, pairs) {
  const of = (name) =>
    coefficientsOf(
      count,
      pairs.map(([a, b, law]) => [a, b, law[name]]),
    );
  const found = { restitution: of("restitution"), friction: of("friction") };
  return found.restitution && found.friction ? found : null;
}

/** For each material of a layer's pairs [i, j] its partners; `own`: with itself, where that pair is not in play. */
function partnersOf(pairs, others, own) {
  const partners = new Map();
  const put = (a, b) => partners.set(a, (partners.get(a) ?? new Set()).add(b));
  for (const [a, b] of pairs) {
    put(a, b);
    put(b, a);
  }
  for (const a of own ? partners.keys() : []) if (!others.some(([i, j]) => i === a && j === a)) put(a, a);
  return partners;
}

/** Materials with the same partners share a group: {material: {member, filter}}, bits from `first` on, and their number. */
function groupsOf(partners, first) {
  const key = (a) => [...partners.get(a)].sort((x, y) => x - y).join(" "),
    keys = [...new Set([...partners.keys()].map(key))];
  const bit = (a) => 1 << (first + keys.indexOf(key(a)));
  const groups = new Map();
  for (const [a, all] of partners)
    groups.set(a, { member: bit(a), filter: [...all].reduce((bits, b) => bits | bit(b), 0) });
  return { groups, count: keys.length };
}

/**
 * Layers [{restitution, friction, groups}] for pairs [i, j, law] of `count` materials. `groups`: {member, filter} of each
 * material in the layer; null where one layer is enough. Null: 16 groups do not suffice, or there are too many materials.
 */
export function layersOf(count, pairs) {
  const whole = rulesOf(count, pairs);
  if (whole) return [{ ...whole, groups: null }];
  if (new Set(pairs.flatMap(([a, b]) => [a, b])).size > MOST_MATERIALS) return null;
  const layers = [];
  for (const pair of [...pairs].sort(([, , a], [, , b]) => a.friction - b.friction || a.restitution - b.restitution)) {
    const home = layers.find((layer) => rulesOf(count, [...layer, pair]));
    if (home) home.push(pair);
    else if (layers.push([pair]) > MOST_GROUPS) return null;
  }
  let used = 0;
  const made = layers.map((layer) => {
    const others = pairs.filter((pair) => !layer.includes(pair) || pair[0] === pair[1]);
    const [one, other] = [false, true].map((own) => groupsOf(partnersOf(layer, others, own), used));
    const { groups, count: bits } = other.count < one.count ? other : one;
    used += bits;
    return { ...rulesOf(count, layer), groups };
  });
  return used <= MOST_GROUPS ? made : null;
}
