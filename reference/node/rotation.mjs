// Three-vectors, unit quaternions (w, x, y, z) from body to world axes, and 3x3 matrices (nine numbers, row by row).

export const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scaled = (s, a) => [s * a[0], s * a[1], s * a[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a) => Math.sqrt(dot(a, a));
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const isZero = (a) => a.every((x) => x === 0);

/** A unit vector orthogonal to a unit vector. */
export function orthogonal(axis) {
  const least = [0, 1, 2].reduce((a, b) => (Math.abs(axis[b]) < Math.abs(axis[a]) ? b : a));
  const unit = [0, 1, 2].map((k) => (k === least ? 1 : 0)), across = minus(unit, scaled(dot(unit, axis), axis));
  return scaled(1 / length(across), across);
}

/** The rotation matrix of a unit quaternion: v_W = R v_B. */
export function matrixOf([w, x, y, z]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}
export const times = (m, v) => [0, 3, 6].map((r) => m[r] * v[0] + m[r + 1] * v[1] + m[r + 2] * v[2]);
export const transposedTimes = (m, v) => [0, 1, 2].map((c) => m[c] * v[0] + m[c + 3] * v[1] + m[c + 6] * v[2]);
export const toWorld = (q_WB, v_B) => times(matrixOf(q_WB), v_B);
export const toBody = (q_WB, v_W) => transposedTimes(matrixOf(q_WB), v_W);

export function product(a, b) {
  return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];
}
export const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];
export function normalised(q) {
  const norm = Math.hypot(...q);
  return q.map((x) => x / norm);
}

/** A unit quaternion of a rotation matrix (Shepperd 1978: the largest of the four squares is the divisor). */
export function quaternionOf(m) {
  const squares = [1 + m[0] + m[4] + m[8], 1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8]];
  const largest = squares.indexOf(Math.max(...squares));
  const wx = m[7] - m[5], wy = m[2] - m[6], wz = m[3] - m[1], xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
  const rows = [[squares[0], wx, wy, wz], [wx, squares[1], xy, xz], [wy, xy, squares[2], yz], [wz, xz, yz, squares[3]]];
  return normalised(rows[largest]);
}

/** The rotation vector [rad] of a unit quaternion, of a length of at most pi: q = exp(v / 2). */
export function rotationVector(q) {
  const [w, ...v] = q[0] < 0 ? q.map((x) => -x) : q;
  const sine = length(v);
  return scaled(sine > 0 ? (2 * Math.atan2(sine, w)) / sine : 2, v);
}

/** The unit quaternion of a rotation by `angle_rad` about a unit axis. */
export const turnAbout = (axis, angle_rad) => [Math.cos(angle_rad / 2), ...scaled(Math.sin(angle_rad / 2), axis)];

/** The unit quaternion of a rotation that turns the z axis onto a unit vector. */
export function fromZ(n) {
  if (n[2] < -1 + 1e-12) return [0, 1, 0, 0];
  return normalised([1 + n[2], -n[1], n[0], 0]);
}

/**
 * Principal axes of a symmetric inertia (nine numbers, kg m2, body axes): I = R diag(moments) R^T with R = matrixOf(q_BP),
 * by Jacobi's rotations (Golub and Van Loan 1996, algorithm 8.4.3). A diagonal inertia gives the identity.
 */
export function principalAxes(inertia_kg_m2) {
  const a = [...inertia_kg_m2];
  let r = [1, 0, 0, 0, 1, 0, 0, 0, 1];
  for (let sweep = 0; sweep < 50; ++sweep) {
    if (a[1] === 0 && a[2] === 0 && a[5] === 0) break;
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
      const off = a[3 * p + q];
      if (off === 0) continue;
      const theta = (a[4 * q] - a[4 * p]) / (2 * off);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
      const c = 1 / Math.sqrt(t * t + 1), s = t * c, k = 3 - p - q;
      const kp = a[3 * k + p], kq = a[3 * k + q];
      a[4 * p] -= t * off;
      a[4 * q] += t * off;
      a[3 * p + q] = a[3 * q + p] = 0;
      a[3 * k + p] = a[3 * p + k] = c * kp - s * kq;
      a[3 * k + q] = a[3 * q + k] = s * kp + c * kq;
      r = r.map((x, i) => (i % 3 === p ? c * x - s * r[i - p + q] : i % 3 === q ? s * r[i - q + p] + c * x : x));
    }
  }
  const q_BP = quaternionOf(r);
  return { moments_kg_m2: [a[0], a[4], a[8]], q_BP: isZero(q_BP.slice(1)) ? [1, 0, 0, 0] : q_BP };
}
