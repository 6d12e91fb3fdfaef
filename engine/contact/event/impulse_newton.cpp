#include "contact/event/impulse_newton.hpp"

#include <Eigen/Core>
#include <Eigen/QR>

namespace atwood::event {

namespace {

template <class S> using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;
template <class S> using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

template <class S> struct Frame { Vec3<S> axis[3]; };  // the normal, and two tangents

template <class S> Frame<S> frame_of(const Vec3<S>& n) {
  const Vec3<S> e = real::abs(n.x) < S(0.6) ? Vec3<S>{S(1), S(0), S(0)} : Vec3<S>{S(0), S(1), S(0)};
  const Vec3<S> t = (S(1) / norm(cross(n, e))) * cross(n, e);
  return {{n, t, cross(n, t)}};
}

// c . (the velocity of the body's point r_c under a unit impulse d at its point r_d).
template <class S>
S response(const ImpactBody<S>& body, const Vec3<S>& r_c, const Vec3<S>& c, const Vec3<S>& r_d, const Vec3<S>& d) {
  const Vec3<S> turn = cross(r_d, d);
  const Vec3<S> w{dot(body.I_inverse_W_row[0], turn), dot(body.I_inverse_W_row[1], turn),
                  dot(body.I_inverse_W_row[2], turn)};
  return body.inverse_mass_per_kg * dot(c, d) + dot(c, cross(w, r_c));
}

template <class S> struct System {
  ImpactProblem<S>& problem;
  ImpactPoint<S>* points;
  int count;
  std::vector<Frame<S>> frames;
  Matrix<S> W;         // relative velocity per unit impulse, three rows and columns a point
  Vector<S> u_0, x_0;  // at the start: relative velocities, impulses

  S friction(int i) const { return problem.proximity.pairs[points[i].pair].friction; }
};

template <class S> System<S> system_of(ImpactProblem<S>& problem, ImpactPoint<S>* points, int count) {
  System<S> system{
      problem, points, count, {}, Matrix<S>(3 * count, 3 * count), Vector<S>(3 * count), Vector<S>(3 * count)};
  for (int i = 0; i < count; ++i) system.frames.push_back(frame_of(points[i].kinematics.normal));
  for (int i = 0; i < count; ++i) {
    const Candidate<S>& on = problem.candidate(points[i]);
    const Vec3<S> u = problem.u(points[i]);
    for (int k = 0; k < 3; ++k) {
      const Vec3<S>& c = system.frames[static_cast<std::size_t>(i)].axis[k];
      system.u_0[3 * i + k] = dot(c, u);
      system.x_0[3 * i + k] = k == 0 ? points[i].normal_N_s : dot(c, points[i].tangential_N_s);
      for (int j = 0; j < count; ++j) {
        const Candidate<S>& of = problem.candidate(points[j]);
        for (int l = 0; l < 3; ++l) {
          const Vec3<S>& d = system.frames[static_cast<std::size_t>(j)].axis[l];
          S sum = S(0);
          const auto add = [&](int body, int other, const ImpactBody<S>& a, const ImpactBody<S>& b, S sign) {
            if (body == other) sum += sign * response(a, a.r_W, c, b.r_W, d);
          };
          add(on.feature_body, of.feature_body, points[i].feature, points[j].feature, S(1));
          add(on.feature_body, of.surface_body, points[i].feature, points[j].surface, S(-1));
          add(on.surface_body, of.feature_body, points[i].surface, points[j].feature, S(-1));
          add(on.surface_body, of.surface_body, points[i].surface, points[j].surface, S(1));
          system.W(3 * i + k, 3 * j + l) = sum;
        }
      }
    }
  }
  return system;
}

// The equations at x, as impulses, and their derivatives.
template <class S> void linearise(const System<S>& system, const Vector<S>& x, Vector<S>& f, Matrix<S>& slope) {
  const Vector<S> u = system.u_0 + system.W * (x - system.x_0);
  for (int i = 0; i < system.count; ++i) {
    const ImpactPoint<S>& point = system.points[i];
    const int n = 3 * i, t = n + 1;
    const S r_n = S(1) / point.inverse_mass_n, r_t = S(1) / point.inverse_mass_t, mu = system.friction(i);
    const S pressed = x[n] - r_n * (u[n] - point.target);
    slope.row(n).setZero();
    f[n] = x[n] - point.least;
    slope(n, n) = S(1);
    if (pressed > point.least) {
      f[n] = r_n * (u[n] - point.target);
      slope.row(n) = r_n * system.W.row(n);
    }
    const S b[2] = {x[t] - r_t * u[t], x[t + 1] - r_t * u[t + 1]};
    const S length = real::sqrt(b[0] * b[0] + b[1] * b[1]), bound = mu * real::max(x[n], S(0));
    for (int k = 0; k < 2; ++k) {
      slope.row(t + k).setZero();
      if (length <= bound && bound > S(0)) {
        f[t + k] = r_t * u[t + k];
        slope.row(t + k) = r_t * system.W.row(t + k);
        continue;
      }
      f[t + k] = x[t + k];
      slope(t + k, t + k) = S(1);
      if (!(bound > S(0)) || !(length > S(0))) continue;
      f[t + k] -= bound * b[k] / length;
      slope(t + k, n) -= mu * b[k] / length;
      for (int l = 0; l < 2; ++l) {  // the derivative of b / |b|, times that of b
        const S turn = bound / length * ((k == l ? S(1) : S(0)) - b[k] * b[l] / (length * length));
        slope.row(t + k) += turn * r_t * system.W.row(t + l);
        slope(t + k, t + l) -= turn;
      }
    }
  }
}

template <class S> S relative_residual(const Vector<S>& f, const Vector<S>& x, int count) {
  S size = S(0);
  for (int i = 0; i < count; ++i) size = real::max(size, x[3 * i]);
  const S largest = f.cwiseAbs().maxCoeff();
  return largest == S(0) ? S(0) : size > S(0) ? largest / size : S(1);
}

template <class S> void apply_change(const System<S>& system, const Vector<S>& x) {
  ImpactProblem<S>& problem = system.problem;
  for (int i = 0; i < system.count; ++i) {
    ImpactPoint<S>& point = system.points[i];
    const Vec3<S>(&axis)[3] = system.frames[static_cast<std::size_t>(i)].axis;
    Vec3<S> change{};
    for (int k = 0; k < 3; ++k) change += (x[3 * i + k] - system.x_0[3 * i + k]) * axis[k];
    apply_impulse(problem, point, change);
    point.normal_N_s = x[3 * i];
    point.tangential_N_s = x[3 * i + 1] * axis[1] + x[3 * i + 2] * axis[2];
  }
}

}  // namespace

template <class S>
SolveReport refine_impulses(ImpactProblem<S>& problem, std::vector<ImpactPoint<S>>& points, int first, int count) {
  constexpr int max_iterations = 60;
  const S tolerance = S(64) * real::epsilon<S>();
  const System<S> system = system_of(problem, points.data() + first, count);
  Vector<S> x = system.x_0, best = x, f(3 * count);
  Matrix<S> slope(3 * count, 3 * count);
  S least{}, residual{};
  int iteration = 0;
  for (; iteration < max_iterations; ++iteration) {
    linearise(system, x, f, slope);
    residual = relative_residual(f, x, count);
    if (iteration == 0 || residual < least) {
      least = residual;
      best = x;
    }
    if (!(residual > tolerance)) break;
    x -= slope.completeOrthogonalDecomposition().solve(f);
    if (!x.allFinite()) break;
  }
  for (int i = 0; i < count; ++i) best[3 * i] = real::max(best[3 * i], system.points[i].least);
  apply_change(system, best);
  return {iteration, static_cast<double>(least), least <= tolerance ? SolveEnd::converged : SolveEnd::capped};
}

#define ATWOOD_IMPULSE_NEWTON(S) \
  template SolveReport refine_impulses<S>(ImpactProblem<S>&, std::vector<ImpactPoint<S>>&, int, int);
ATWOOD_IMPULSE_NEWTON(float)
ATWOOD_IMPULSE_NEWTON(double)
ATWOOD_IMPULSE_NEWTON(long double)
#undef ATWOOD_IMPULSE_NEWTON

}  // namespace atwood::event
