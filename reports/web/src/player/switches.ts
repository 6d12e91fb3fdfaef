// What can be switched on and off in the picture, and what of it a scene has.
import { Force } from './data';
import { Motion } from './motion';

export const kSwitches = ['trails', 'contacts', 'normals', 'impulses', 'friction', 'thrusters', 'point-forces', 'other-forces', 'joints', 'names', 'axes', 'grid'] as const;
export type Switch = typeof kSwitches[number];
export type Shown = Record<Switch, boolean>;

// Of contacts `normals` are the normal forces; of events, impacts are impulses and the others belong to the contact points.
export function shownAtFirst(motion: Motion): Shown {
  const light = motion.page.motion.moving.length <= 30;
  return { trails: light, contacts: light, normals: light, impulses: light, friction: light, thrusters: true, 'point-forces': true, 'other-forces': true, joints: true, names: false, axes: true, grid: false };
}

export function switchOf(force: Force): Switch {
  return force.kind === 'thruster' ? 'thrusters' : force.kind === 'point-force' ? 'point-forces' : 'other-forces';
}

// The switches that change something, with their labels.
export function switchesOf(motion: Motion): [Switch, string][] {
  const { runs } = motion, { scene } = motion.page, forces = (name: Switch) => scene.forces.filter((force) => switchOf(force) === name);
  const contacts = runs.some((run) => run.contacts?.length), impacts = runs.some((run) => run.events.some((event) => event[1] === 'impact'));
  const others = [...new Set(forces('other-forces').map((force) => force.kind))];
  const labels: Record<Switch, string | false> = {
    trails: 'trails',
    contacts: (contacts || runs.some((run) => run.events.some((event) => event[1] !== 'impact'))) && 'contact points',
    normals: contacts && 'normal forces',
    impulses: impacts && 'impulses',
    friction: runs.some((run) => run.contacts?.some((c) => c[8] || c[9] || c[10])) && 'friction',
    thrusters: forces('thrusters').length > 0 && 'thrusters',
    'point-forces': forces('point-forces').length > 0 && 'point forces',
    'other-forces': others.length > 0 && others.map((kind) => `${kind}s`).join(', '),
    joints: scene.joints.length > 0 && 'joints',
    names: 'names', axes: 'axes',
    grid: !scene.bodies.some((body) => body.shape.kind === 'plane') && 'grid',
  };
  return kSwitches.flatMap((name): [Switch, string][] => labels[name] ? [[name, labels[name]]] : []);
}
