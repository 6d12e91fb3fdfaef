// The fields of a fluid that are drawn, and the colours of their values.
export type FieldName = 'speed' | 'pressure' | 'temperature' | 'error';
export const fieldWords: Record<FieldName, string> = { speed: 'speed [m/s]', pressure: 'pressure [Pa]', temperature: 'temperature [K]', error: 'error' };

export interface ValueRange { low: number; high: number }  // of an error: logarithms to base 10

// Cividis (Nunez, Anderton, Renslow 2018): brightness rises evenly, the same to colour-blind readers and in grey.
const palette = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
export function colour(share: number): string {
  const at = Math.min(Math.max(share, 0), 1) * (palette.length - 1), i = Math.min(Math.floor(at), palette.length - 2);
  return `rgb(${palette[i].map((low, k) => Math.round(low + (at - i) * (palette[i + 1][k] - low))).join(',')})`;
}
export const gradient = `linear-gradient(90deg, ${palette.map((_, i) => colour(i / (palette.length - 1))).join(', ')})`;

export function colourIn(range: ValueRange, value: number): string { return colour(range.high > range.low ? (value - range.low) / (range.high - range.low) : 0.5); }
