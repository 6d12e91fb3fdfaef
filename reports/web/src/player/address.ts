// The address of the page after #: everything that its reader has chosen, so that a link shows what its sender saw. Of an
// address that is read, words without a meaning and numbers that are not finite or out of range count as absent.
export interface View {
  t?: number;                  // [s]; absent: the clock runs
  k?: number;                  // magnification
  hidden?: number[];           // runs; absent: as at first
  camera?: number[];           // yaw, pitch, distance, target; of a camera that follows a body, the target from that body
  speed?: string; follow?: string; field?: string; particles?: string;  // values of the selects; absent: as at first
  loop?: boolean;
  wait?: 'wait' | 'held';      // held: until the reader lets go
  on?: string[]; off?: string[];  // switches that are not as at first
  theme?: 'light' | 'dark';
  canvas?: boolean;            // drawn without WebGL
}

const kSelects = ['speed', 'follow', 'field', 'particles'] as const;
const kMostMagnified = 1e30, kMostYaw = 1e4;

export function written(view: View): string {
  const words = new URLSearchParams();
  if (view.t !== undefined) words.set('t', digits(view.t, 7));
  if (view.k !== undefined) words.set('k', String(view.k));
  if (view.hidden) words.set('hide', view.hidden.join('.') || 'none');
  for (const name of kSelects) if (view[name] !== undefined) words.set(name, view[name]!);
  if (view.loop !== undefined) words.set('loop', view.loop ? '1' : '0');
  if (view.wait) words.set('wait', view.wait === 'held' ? 'held' : '1');
  for (const name of ['on', 'off'] as const) if (view[name]?.length) words.set(name, view[name]!.join('.'));
  if (view.theme) words.set('theme', view.theme);
  if (view.camera) {
    // The target to a millionth of the distance, however far from the origin the scene is.
    const [yaw, pitch, distance, ...target] = view.camera;
    words.set('view', [...[yaw, pitch, distance].map((x) => digits(x, 7)), ...target.map((x) => digits(x, 7 + Math.max(0, Math.min(10, Math.ceil(Math.log10(Math.abs(x) / distance) || 0)))))].join('_'));
  }
  if (view.canvas) words.set('canvas', '1');
  return `#${words}`;
}

export function readAddress(hash: string): View {
  const words = new URLSearchParams(hash.slice(1)), view: View = {};
  const inside = (name: string, low: number, high: number) => {
    const text = words.get(name), x = Number(text);
    return text && x >= low && x <= high ? x : undefined;
  };
  view.t = inside('t', 0, Number.MAX_VALUE);
  view.k = inside('k', 1, kMostMagnified);
  const hidden = words.get('hide');
  if (hidden === 'none') view.hidden = [];
  else if (hidden && /^\d+(\.\d+)*$/.test(hidden)) view.hidden = hidden.split('.').map(Number);
  for (const name of kSelects) view[name] = words.get(name) ?? undefined;
  const loop = words.get('loop'), wait = words.get('wait'), theme = words.get('theme');
  if (loop === '0' || loop === '1') view.loop = loop === '1';
  if (wait === '1' || wait === 'held') view.wait = wait === 'held' ? 'held' : 'wait';
  if (theme === 'light' || theme === 'dark') view.theme = theme;
  for (const name of ['on', 'off'] as const) view[name] = words.get(name)?.split('.') ?? [];
  const texts = (words.get('view') ?? '').split('_'), camera = texts.map(Number);
  if (texts.length === 6 && texts.every(Boolean) && camera.every(Number.isFinite) && Math.abs(camera[0]) <= kMostYaw && camera[2] > 0) view.camera = camera;
  view.canvas = words.has('canvas');
  return view;
}

function digits(x: number, n: number): string { return String(Number(x.toPrecision(n))); }
