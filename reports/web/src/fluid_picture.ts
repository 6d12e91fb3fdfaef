// The particles of a fluid at the end of a run, as squares coloured by their speed.
import { Picture, Report, figure, real } from './data';
import { svg } from './dom';
import { FieldName, colour, fieldWords } from './field_colours';

// Of the methods of a scenario, ours where it has one; the field is the first that is not the same everywhere.
export function fluidOf(report: Report, id: string): { picture: Picture; field: FieldName } | null {
  const all = report.pictures?.filter((p) => report.strings[p.s] === id) ?? [];
  const picture = all.find((p) => report.strings[p.m].startsWith('atwood/')) ?? all[0];
  const field = picture && (['speed', 'pressure', 'temperature'] as const).find((name) => picture[name] && real(picture[name]!.high) > real(picture[name]!.low));
  return picture && field ? { picture, field } : null;
}

export function fluidWords(report: Report, { picture, field }: { picture: Picture; field: FieldName }): string {
  const [name, unit] = fieldWords[field].split(' ');
  return `The particles at ${figure(real(picture.t), 3)} s of ${report.strings[picture.m]}, coloured by ${name}: ${figure(real(picture[field]!.low), 3)} (dark) to ${figure(real(picture[field]!.high), 3)} ${unit.replace(/[[\]]/g, '')} (bright)`;
}

// At most `most` particles; fewer stand for larger squares. One path for each colour.
export function fluidPicture({ picture, field }: { picture: Picture; field: FieldName }, label: string, width: number, height: number, most: number): SVGElement {
  const shades = 24, count = picture.x.at.length, every = Math.max(1, Math.ceil(count / most));
  const wide = real(picture.x.high) - real(picture.x.low) || 1, high = real(picture.y.high) - real(picture.y.low) || 1;
  const scale = Math.min((width - 16) / wide, (height - 16) / high), side = Math.max(1, 1.1 * real(picture.side) * scale * Math.sqrt(every));
  const paths: string[] = Array(shades).fill('');
  for (let i = 0; i < count; i += every) {
    const x = width / 2 + (picture.x.at[i] / 4096 - 0.5) * wide * scale, y = height / 2 - (picture.y.at[i] / 4096 - 0.5) * high * scale;
    paths[Math.min(shades - 1, Math.floor(picture[field]!.at[i] / 250 * shades))] += `M${(x - side / 2).toFixed(1)} ${(y - side / 2).toFixed(1)}h${side.toFixed(1)}v${side.toFixed(1)}h-${side.toFixed(1)}z`;
  }
  return svg('svg', { class: 'picture', viewBox: `0 0 ${width} ${height}`, ...(label ? { role: 'img', 'aria-label': label } : { 'aria-hidden': 'true' }) },
    ...paths.flatMap((d, k) => (d ? [svg('path', { d, fill: colour((k + 0.5) / shades) })] : [])));
}
