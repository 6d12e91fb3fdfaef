// The drawing calls of a canvas, written as SVG: to save what is on the screen as lines and areas.

export type Ink = Pick<CanvasRenderingContext2D, 'beginPath' | 'moveTo' | 'lineTo' | 'closePath' | 'arc' | 'fill' | 'stroke' | 'fillRect' | 'clearRect' | 'fillText' | 'strokeText' | 'setLineDash' |
  'setTransform' | 'fillStyle' | 'strokeStyle' | 'lineWidth' | 'lineCap' | 'lineJoin' | 'globalAlpha' | 'font' | 'textAlign' | 'textBaseline'>;

const escaped = (text: string) => text.replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]!);
const short = (x: number) => `${Math.round(x * 100) / 100}`;

export class SvgInk implements Ink {
  fillStyle: Ink['fillStyle'] = '#000';
  strokeStyle: Ink['strokeStyle'] = '#000';
  lineWidth = 1;
  lineCap: CanvasLineCap = 'butt';
  lineJoin: CanvasLineJoin = 'miter';
  globalAlpha = 1;
  font = '10px sans-serif';
  textAlign: CanvasTextAlign = 'start';
  textBaseline: CanvasTextBaseline = 'alphabetic';
  private path = '';
  private dash = '';
  private parts: string[] = [];

  clearRect(): void {}
  setTransform(): void {}  // units are those of the page already
  setLineDash(lengths: Iterable<number>): void { this.dash = [...lengths].join(' '); }
  beginPath(): void { this.path = ''; }
  moveTo(x: number, y: number): void { this.path += `M${short(x)} ${short(y)}`; }
  lineTo(x: number, y: number): void { this.path += `${this.path ? 'L' : 'M'}${short(x)} ${short(y)}`; }
  closePath(): void { this.path += 'Z'; }
  arc(x: number, y: number, radius: number, from: number, to: number): void {
    const halves = 2, turn = (to - from) / halves, at = (angle: number) => `${short(x + radius * Math.cos(angle))} ${short(y + radius * Math.sin(angle))}`;
    this.path += `${this.path ? 'L' : 'M'}${at(from)}`;
    for (let half = 1; half <= halves; half += 1) this.path += `A${short(radius)} ${short(radius)} 0 0 ${turn > 0 ? 1 : 0} ${at(from + half * turn)}`;
  }
  fill(): void { if (this.path) this.parts.push(`<path d="${this.path}" fill="${escaped(String(this.fillStyle))}"${this.opacity()}/>`); }
  stroke(): void { if (this.path) this.parts.push(`<path d="${this.path}" fill="none"${this.line()}${this.opacity()}/>`); }
  fillRect(x: number, y: number, width: number, height: number): void {
    this.parts.push(`<rect x="${short(x)}" y="${short(y)}" width="${short(width)}" height="${short(height)}" fill="${escaped(String(this.fillStyle))}"${this.opacity()}/>`);
  }
  fillText(text: string, x: number, y: number): void { this.text(text, x, y, `fill="${escaped(String(this.fillStyle))}"`); }
  strokeText(text: string, x: number, y: number): void { this.text(text, x, y, `fill="none"${this.line()}`); }

  svg(width: number, height: number): string {
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${short(width)}" height="${short(height)}" viewBox="0 0 ${short(width)} ${short(height)}">${this.parts.join('\n')}</svg>\n`;
  }

  private line(): string {
    return ` stroke="${escaped(String(this.strokeStyle))}" stroke-width="${this.lineWidth}" stroke-linecap="${this.lineCap}" stroke-linejoin="${this.lineJoin}"${this.dash ? ` stroke-dasharray="${this.dash}"` : ''}`;
  }
  private opacity(): string { return this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : ''; }
  private text(text: string, x: number, y: number, paint: string): void {
    const anchor = { center: 'middle', right: 'end', end: 'end', left: 'start', start: 'start' }[this.textAlign], middle = this.textBaseline === 'middle';
    this.parts.push(`<text x="${short(x)}" y="${short(y)}" style="font:${escaped(this.font)}" text-anchor="${anchor}"${middle ? ' dominant-baseline="central"' : ''} ${paint}${this.opacity()}>${escaped(text)}</text>`);
  }
}
