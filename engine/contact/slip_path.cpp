#include "contact/slip_path.hpp"

#include <limits>

#include "math/bracketed_root.hpp"

namespace atwood {

namespace {

// Compression up to v_n = 0, then restitution by the hypothesis. Poisson's and Stronge's laws never gain energy.
// Stronge's: the normal work is -(1 - e^2) of what compression took, friction's is never positive. Poisson's: with d =
// dJ/dp,
//   dT/dp = u . d,
// and its slope d . K d never grows along the path (the least over the disk of friction in stick and in slip that sets
// in anew; d/dp = -2 mu (slip's turning)^2 / |u_t| while it turns), so dT/dp is concave and its integral over [0, (1 +
// e) p_c] is at most that of its tangent at p_c, where it is -mu |u_t|: not positive for e <= 1.
template <class S> struct SlipState {
  const ImpactLaw<S>& law;
  const S (&K)[3][3];
  const S (&u0)[3];
  S J[3]{};  // impulse so far, on b along t1, t2, n
  S work{};  // of the normal impulse so far
  bool compressed = false, done = false;
  bool stopped = false;  // no slip now
  S p_compression{}, work_compression{};
  SolveReport solve{};  // of all iterations so far

  S u(int i) const { return u0[i] + (K[i][0] * J[0] + K[i][1] * J[1] + K[i][2] * J[2]); }
  S speed() const { return stopped ? S(0) : real::sqrt(u(0) * u(0) + u(1) * u(1)); }

  void cap(S residual) {
    solve.residual = static_cast<double>(residual);
    solve.ended = SolveEnd::capped;
  }

  // The normal impulse up to the end of the phase while v_n grows by `slope` per N s; -1: the phase does not end.
  S impulse_left(S vn, S slope) const {
    const S e = law.restitution;
    if (!compressed) return slope > S(0) ? -vn / slope : S(-1);
    if (law.hypothesis == Restitution::poisson) return p_compression + e * p_compression - J[2];
    if (law.hypothesis == Restitution::newton) return slope > S(0) ? (-e * u0[2] - vn) / slope : S(-1);
    const S missing = work_compression - e * e * work_compression - work;  // = vn dp + slope dp^2 / 2
    if (!(missing > S(0))) return S(0);
    const S square = vn * vn + S(2) * slope * missing;
    if (square < S(0) || (slope <= S(0) && vn <= S(0))) return S(-1);  // v_n becomes negative first
    const S root = real::sqrt(square);
    return vn > S(0) ? S(2) * missing / (vn + root) : (root - vn) / slope;
  }
  void next_phase() {
    if (compressed) {
      done = true;
      return;
    }
    compressed = true;
    p_compression = J[2];
    work_compression = work;
    if (!(law.restitution > S(0))) done = true;
  }
};

// f = -K_tt^-1 K_tn, and |f|.
template <class S> S sticking_friction(const S (&K)[3][3], S (&f)[2]) {
  const S det = K[0][0] * K[1][1] - K[0][1] * K[0][1];
  f[0] = -(K[1][1] * K[0][2] - K[0][1] * K[1][2]) / det;
  f[1] = -(K[0][0] * K[1][2] - K[0][1] * K[0][2]) / det;
  return real::sqrt(f[0] * f[0] + f[1] * f[1]);
}

// The direction s at the onset of slip: (mu K_tt + lambda) s = K_tn, |s| = 1, lambda > 0. |s| falls with lambda from
// |f| / mu > 1 to 0, so there is one root; by bisection, at most once an impact.
template <class S> BracketedRoot<S> onset_direction(const S (&K)[3][3], S mu, S (&s)[2]) {
  const auto solve_at = [&](S lambda) {
    const S a = mu * K[0][0] + lambda, b = mu * K[0][1], d = mu * K[1][1] + lambda, det = a * d - b * b;
    s[0] = (d * K[0][2] - b * K[1][2]) / det;
    s[1] = (a * K[1][2] - b * K[0][2]) / det;
    return s[0] * s[0] + s[1] * s[1] > S(1);
  };
  const S largest = real::sqrt(K[0][2] * K[0][2] + K[1][2] * K[1][2]);
  const BracketedRoot<S> root = bisect(solve_at, S(0), largest, S(0), 200);
  solve_at(root.low + (root.high - root.low) / S(2));
  const S length = real::sqrt(s[0] * s[0] + s[1] * s[1]);
  s[0] = s[0] / length;
  s[1] = s[1] / length;
  return {root.low / largest, root.high / largest, root.evaluations, root.converged};
}

// Slip of constant direction, or none: J grows along (d0, d1, 1) to the end of the phase, or until slip along s stops.
template <class S> void advance_straight(SlipState<S>& path, S d0, S d1, const S* s) {
  const auto& K = path.K;
  const S slope = K[2][0] * d0 + K[2][1] * d1 + K[2][2];
  const S vn = path.u(2);
  S dp = path.impulse_left(vn, slope);
  bool stops = false;
  if (s != nullptr && path.speed() > S(0)) {
    const S braking =
        -(s[0] * (K[0][0] * d0 + K[0][1] * d1 + K[0][2]) + s[1] * (K[1][0] * d0 + K[1][1] * d1 + K[1][2]));
    const S to_stop = braking > S(0) ? path.speed() / braking : S(-1);
    if (to_stop >= S(0) && (dp < S(0) || to_stop < dp)) {
      dp = to_stop;
      stops = true;
    }
  }
  if (dp < S(0)) {  // impossible: slip that lasts has a positive slope (d . K d > 0)
    path.cap(std::numeric_limits<S>::infinity());
    path.done = true;
    return;
  }
  path.work += vn * dp + slope * dp * dp / S(2);
  path.J[0] += d0 * dp;
  path.J[1] += d1 * dp;
  path.J[2] += dp;
  path.stopped = path.stopped || stops;
  if (!stops) path.next_phase();
}

// ---- slip that turns ----------------------------------------------------------------------------------------------
// In tau, dp = |u_t| dtau: the equations stay smooth as slip stops (it then takes infinite tau).
//   z = (j_1, j_2, p, W):  z' = (-mu u_1, -mu u_2, |u_t|, |u_t| v_n)
template <class S> struct Turn { S z[4]; };

template <class S> Turn<S> turn_rate(const SlipState<S>& path, const Turn<S>& at) {
  const auto& K = path.K;
  const auto& z = at.z;
  S u[3];
  for (int i = 0; i < 3; ++i) u[i] = path.u0[i] + (K[i][0] * z[0] + K[i][1] * z[1] + K[i][2] * z[2]);
  const S speed = real::sqrt(u[0] * u[0] + u[1] * u[1]);
  return {{-path.law.friction * u[0], -path.law.friction * u[1], speed, speed * u[2]}};
}

// Gragg's modified midpoint rule, a step h in `parts` substeps.
template <class S>
Turn<S> midpoint_rule(const SlipState<S>& path, const Turn<S>& from, const Turn<S>& first_rate, S h, int parts) {
  const S part = h / S(parts);
  Turn<S> back = from, here = from;
  for (int i = 0; i < 4; ++i) here.z[i] += part * first_rate.z[i];
  for (int m = 1; m < parts; ++m) {
    const Turn<S> rate = turn_rate(path, here);
    for (int i = 0; i < 4; ++i) {
      const S ahead = back.z[i] + S(2) * part * rate.z[i];
      back.z[i] = here.z[i];
      here.z[i] = ahead;
    }
  }
  const Turn<S> rate = turn_rate(path, here);
  Turn<S> smooth;
  for (int i = 0; i < 4; ++i) smooth.z[i] = (here.z[i] + back.z[i] + part * rate.z[i]) / S(2);
  return smooth;
}

// The same with 2, 4, .. 16 substeps, extrapolated in h^2 to order 16 by the scheme of Aitken and Neville; `error`: the
// difference of the last two orders.
template <class S> Turn<S> turn_step(const SlipState<S>& path, const Turn<S>& from, S h, S& error) {
  constexpr int columns = 8;
  Turn<S> table[columns]{};
  const Turn<S> first = turn_rate(path, from);
  for (int k = 0; k < columns; ++k) {
    Turn<S> above = table[0];
    table[0] = midpoint_rule(path, from, first, h, 2 * (k + 1));
    for (int j = 1; j <= k; ++j) {
      const Turn<S> kept = table[j];
      const S ratio = S(k + 1) / S(k + 1 - j);
      for (int i = 0; i < 4; ++i)
        table[j].z[i] = table[j - 1].z[i] + (table[j - 1].z[i] - above.z[i]) / (ratio * ratio - S(1));
      above = kept;
    }
  }
  error = S(0);
  for (int i = 0; i < 3; ++i) error = real::max(error, real::abs(table[columns - 1].z[i] - table[columns - 2].z[i]));
  return table[columns - 1];
}

// Switching function of the phase: negative until it ends.
template <class S> S phase_left(const SlipState<S>& path, const Turn<S>& at) {
  const auto& K = path.K;
  const S vn = path.u0[2] + (K[2][0] * at.z[0] + K[2][1] * at.z[1] + K[2][2] * at.z[2]);
  const S e = path.law.restitution;
  if (!path.compressed) return vn;
  if (path.law.hypothesis == Restitution::newton) return vn + e * path.u0[2];
  if (path.law.hypothesis == Restitution::poisson) return at.z[2] - (S(1) + e) * path.p_compression;
  return at.z[3] - (S(1) - e * e) * path.work_compression;
}

// Does friction against the slip keep its direction?
template <class S> bool keeps_direction(const SlipState<S>& path, const S (&s)[2]) {
  const auto& K = path.K;
  const S mu = path.law.friction;
  const S g0 = K[0][2] - mu * (K[0][0] * s[0] + K[0][1] * s[1]), g1 = K[1][2] - mu * (K[1][0] * s[0] + K[1][1] * s[1]);
  return real::abs(g1 * s[0] - g0 * s[1]) <= S(32) * real::epsilon<S>() * (K[0][0] + K[1][1] + K[2][2]) * (S(1) + mu);
}

// Integrates turning slip to the end of the phase, or until it stops or keeps its direction. Fails after 4000 steps.
template <class S> void integrate_turning_slip(SlipState<S>& path) {
  const auto& K = path.K;
  const S tolerance = S(64) * real::epsilon<S>();
  const S asked = (real::abs(path.u0[0]) + real::abs(path.u0[1]) + real::abs(path.u0[2])) / K[2][2];
  S size = asked;
  Turn<S> at{{path.J[0], path.J[1], path.J[2], path.work}};
  S h = S(0.25) / ((K[0][0] + K[1][1] + K[2][2]) * (S(1) + path.law.friction));
  const auto take = [&](const Turn<S>& to) {
    at = to;
    for (int i = 0; i < 3; ++i) path.J[i] = to.z[i];
    path.work = to.z[3];
    size = asked + real::abs(to.z[0]) + real::abs(to.z[1]) + real::abs(to.z[2]);
  };
  constexpr int max_steps = 4000;
  S error{};
  for (int steps = 0; steps < max_steps; ++steps) {
    ++path.solve.iterations;
    Turn<S> next = turn_step(path, at, h, error);
    if (!(error <= tolerance * size)) {
      h = h / S(2);
      continue;
    }
    if (const S beyond = phase_left(path, next); beyond >= S(0)) {
      const auto left_after = [&](S length) {
        const Turn<S> tried = turn_step(path, at, length, error);
        const S left = phase_left(path, tried);
        if (!(left < S(0))) next = tried;
        return left;
      };
      const BracketedRoot<S> root =
          false_position(left_after, S(0), phase_left(path, at), h, beyond, real::epsilon<S>(), 100);
      if (!root.converged && root.evaluations > 0) break;
      take(next);
      path.next_phase();
      return;
    }
    take(next);
    if (error < tolerance * size / S(1000)) h = h * S(1.5);
    const S speed = path.speed();
    if (speed <= S(8) * tolerance * size * (K[0][0] + K[1][1])) {  // as far as J is known
      path.stopped = true;
      return;
    }
    const S s[2] = {path.u(0) / speed, path.u(1) / speed};
    if (keeps_direction(path, s)) return;
  }
  path.cap(error / size);
  path.done = true;
}

}  // namespace

template <class S> SlipPath<S> slip_path(const ImpactLaw<S>& law, const S (&K)[3][3], const S (&u0)[3]) {
  SlipState<S> path{law, K, u0};
  const S mu = law.friction;
  path.stopped = u0[0] == S(0) && u0[1] == S(0);
  constexpr int max_segments = 64;
  for (int segment = 0; segment < max_segments && !path.done; ++segment) {
    const S speed = path.speed();
    if (!path.stopped && speed > S(0)) {
      const S s[2] = {path.u(0) / speed, path.u(1) / speed};
      if (keeps_direction(path, s)) advance_straight(path, -mu * s[0], -mu * s[1], s);
      else integrate_turning_slip(path);
      continue;
    }
    path.stopped = true;
    S f[2];
    if (sticking_friction(K, f) <= mu) {
      advance_straight(path, f[0], f[1], static_cast<const S*>(nullptr));
    } else {
      S s[2];
      const BracketedRoot<S> onset = onset_direction(K, mu, s);
      path.solve.iterations += onset.evaluations;
      if (!onset.converged) path.cap(onset.high - onset.low);
      advance_straight(path, -mu * s[0], -mu * s[1], static_cast<const S*>(nullptr));
    }
  }
  if (!path.done) path.cap(std::numeric_limits<S>::infinity());
  return {{path.J[0], path.J[1], path.J[2]}, path.solve};
}

template SlipPath<float> slip_path<float>(const ImpactLaw<float>&, const float (&)[3][3], const float (&)[3]);
template SlipPath<double> slip_path<double>(const ImpactLaw<double>&, const double (&)[3][3], const double (&)[3]);
template SlipPath<long double> slip_path<long double>(const ImpactLaw<long double>&, const long double (&)[3][3],
                                                      const long double (&)[3]);

}  // namespace atwood
