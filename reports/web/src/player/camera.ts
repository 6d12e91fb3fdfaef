// A camera that turns about a point, and the projection that everything is drawn with.
import { Vec, add, cross, dot, length, scale, sub, unit } from './vectors';

export const kField = 32 * Math.PI / 180;  // vertical field of view [rad]
export const kMostPitch = 1.55;            // short of straight down, where up has no direction [rad]

export class Camera {
  target: Vec = [0, 0, 0];
  distance = 1;
  yaw = 0;
  pitch = 0;
  width = 1;
  height = 1;
  up: Vec = [0, 0, 1];
  front: Vec = [0, -1, 0];  // where the camera stands at yaw and pitch 0, seen from the target

  // Unit vectors to the right, up and towards the viewer.
  axes(): [Vec, Vec, Vec] {
    const side = cross(this.up, this.front);
    const level = add(scale(this.front, Math.cos(this.yaw)), scale(side, Math.sin(this.yaw)));
    const back = add(scale(level, Math.cos(this.pitch)), scale(this.up, Math.sin(this.pitch)));
    const right = unit(cross(this.up, level));
    return [right, cross(back, right), back];
  }

  // Pixels across one metre at the target.
  get pixels(): number { return this.height / (2 * Math.tan(kField / 2) * this.distance); }

  // A function to pixels from the left and from the top, and the depth in front of the camera (<= 0: behind it).
  projection(): (p: Vec) => Vec {
    const [right, up, back] = this.axes(), f = this.height / (2 * Math.tan(kField / 2));
    const { target, distance, width, height } = this;
    return (p) => {
      const x = p[0] - target[0], y = p[1] - target[1], z = p[2] - target[2];
      const depth = distance - (x * back[0] + y * back[1] + z * back[2]), s = f / depth;
      return [width / 2 + (x * right[0] + y * right[1] + z * right[2]) * s, height / 2 - (x * up[0] + y * up[1] + z * up[2]) * s, depth];
    };
  }

  orbit(dx: number, dy: number): void {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(Math.max(this.pitch + dy * 0.008, -kMostPitch), kMostPitch);
  }
  pan(dx: number, dy: number): void {
    const [right, up] = this.axes(), metre = 1 / this.pixels;
    this.target = add(this.target, add(scale(right, -dx * metre), scale(up, dy * metre)));
  }
  // Zooms so that the place under (x, y), at the depth of the target, stays there.
  zoom(factor: number, x = this.width / 2, y = this.height / 2): void {
    const [right, up] = this.axes(), metre = (1 - factor) / this.pixels;
    this.target = add(this.target, add(scale(right, (x - this.width / 2) * metre), scale(up, (this.height / 2 - y) * metre)));
    this.distance *= factor;
  }

  // The nearest view, along the present direction, that has all these balls in the middle of the picture.
  fit(balls: { p: Vec; r: number }[]): void {
    if (!balls.length) return;
    const axes = this.axes(), tangent = Math.tan(kField / 2), wide = Math.max(0.2, this.width / this.height);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { p, r } of balls) axes.forEach((axis, i) => {
      low[i] = Math.min(low[i], dot(axis, p) - r);
      high[i] = Math.max(high[i], dot(axis, p) + r);
    });
    const middle = low.map((x, i) => (x + high[i]) / 2), [right, up, back] = axes;
    this.target = add(add(scale(right, middle[0]), scale(up, middle[1])), scale(back, middle[2]));
    let distance = 0;
    for (const { p, r } of balls) {
      const d = sub(p, this.target), near = dot(back, d) + r;
      distance = Math.max(distance, near + (Math.abs(dot(up, d)) + r) / tangent, near + (Math.abs(dot(right, d)) + r) / (tangent * wide));
    }
    this.distance = distance > 0 ? distance * 1.12 : Math.max(1, length(this.target));
  }
}
