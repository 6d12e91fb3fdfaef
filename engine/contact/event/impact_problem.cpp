#include "contact/event/impact_problem.hpp"

#include <algorithm>

#include "contact/event/impulse_newton.hpp"

namespace atwood::event {

template <class S> ImpactLaw<S> law_of(const Proximity<S>& proximity, const EventOptions& options, int pair) {
  const ShapePair<S>& p = proximity.pairs[pair];
  return {p.last_bounce ? S(0) : p.restitution, p.friction, p.rolling_friction_m, options.restitution};
}

namespace {

template <class S>
void take_velocities(Bodies<S>& bodies, const Candidate<S>& candidate, const ImpactBody<S>& surface,
                     const ImpactBody<S>& feature) {
  if (bodies.moves[candidate.surface_body]) {
    bodies.poses[candidate.surface_body].v = surface.v_W;
    bodies.poses[candidate.surface_body].w = surface.w_W;
  }
  if (bodies.moves[candidate.feature_body]) {
    bodies.poses[candidate.feature_body].v = feature.v_W;
    bodies.poses[candidate.feature_body].w = feature.w_W;
  }
}

}  // namespace

template <class S> void collide_point(ImpactProblem<S>& problem, ImpactPoint<S>& point) {
  const Candidate<S>& candidate = problem.candidate(point);
  ImpactBody<S> surface = impact_body(problem.bodies, candidate.surface_body, point.kinematics.x),
                feature = impact_body(problem.bodies, candidate.feature_body, point.kinematics.x);
  const Impulse<S> impulse =
      collide(law_of(problem.proximity, problem.options, point.pair), point.kinematics.normal, surface, feature);
  take_velocities(problem.bodies, candidate, surface, feature);
  problem.impacts.applied.push_back(
      {point.pair, candidate.feature_body == problem.proximity.pairs[point.pair].a, point.kinematics, impulse});
}

namespace {

// ---- several points of one pair that move alike -------------------------------------------------------------------
// Is x inside the convex hull of the points, which lie on a plane of normal n?
template <class S>
bool supported(const ImpactPoint<S>* points, int count, const Vec3<S>& n, const Vec3<S>& x, S tiny_m) {
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < i; ++j) {
      const Vec3<S>& from = points[j].kinematics.x;
      const Vec3<S> side = cross(n, points[i].kinematics.x - from);
      const S tiny = tiny_m * norm(side);
      S least = S(0), most = S(0);
      for (int k = 0; k < count; ++k) {
        least = real::min(least, dot(side, points[k].kinematics.x - from));
        most = real::max(most, dot(side, points[k].kinematics.x - from));
      }
      const S at = dot(side, x - from);
      if ((most <= tiny && at > tiny) || (least >= -tiny && at < -tiny)) return false;
    }
  return true;
}

}  // namespace

// An edge that lands on a face, or a face without friction: the points have equal velocities, and keep them if the
// impulse acts below the centre of mass. They then equal one point there, and every impact law holds as for one.
template <class S> bool collide_as_one_point(ImpactProblem<S>& problem, int first, int count) {
  const ImpactPoint<S>* points = &problem.impacts.points[first];
  const Candidate<S>& candidate = problem.candidate(points[0]);
  const Vec3<S>& n = points[0].kinematics.normal;
  const S tiny_m = S(4) * problem.bodies.gap_round_off();
  const Vec3<S> u = problem.u(points[0]), along = points[1].kinematics.x - points[0].kinematics.x;
  for (int i = 1; i < count; ++i)
    if (norm(points[i].kinematics.normal - n) > S(64) * real::epsilon<S>() ||
        norm(problem.u(points[i]) - u) > problem.approach_round_off ||
        problem.candidate(points[i]).feature_body != candidate.feature_body)
      return false;
  ImpactPoint<S> one = points[0];
  const Vec3<S> from =
      problem.bodies
          .poses[problem.bodies.moves[candidate.feature_body] ? candidate.feature_body : candidate.surface_body]
          .p -
      points[0].kinematics.x;
  one.kinematics.x += count == 2 ? (dot(from, along) / dot(along, along)) * along : from - dot(from, n) * n;
  if (!supported(points, count, n, one.kinematics.x, tiny_m)) return false;
  if (count == 2 && !(dot(one.kinematics.x - points[0].kinematics.x, one.kinematics.x - points[1].kinematics.x) < S(0)))
    return false;
  ImpactBody<S> surface = impact_body(problem.bodies, candidate.surface_body, one.kinematics.x);
  ImpactBody<S> feature = impact_body(problem.bodies, candidate.feature_body, one.kinematics.x);
  const Impulse<S> impulse = collide(law_of(problem.proximity, problem.options, one.pair), n, surface, feature);
  const Vec3<S> turns = feature.w_W - surface.w_W;
  for (int i = 0; i < count; ++i)
    if (norm(cross(turns, points[i].kinematics.x - one.kinematics.x)) > S(16) * problem.approach_round_off)
      return false;
  take_velocities(problem.bodies, candidate, surface, feature);
  problem.impacts.applied.push_back(
      {one.pair, candidate.feature_body == problem.proximity.pairs[one.pair].a, one.kinematics, impulse});
  return true;
}

// ---- several points at once ---------------------------------------------------------------------------------------
template <class S> void apply_impulse(ImpactProblem<S>& problem, ImpactPoint<S>& point, const Vec3<S>& impulse) {
  const Candidate<S>& candidate = problem.candidate(point);
  const auto apply = [&](int body, const ImpactBody<S>& side, const Vec3<S>& j) {
    if (!problem.bodies.moves[body]) return;
    const Vec3<S> turn = cross(side.r_W, j);
    problem.bodies.poses[body].v += side.inverse_mass_per_kg * j;
    problem.bodies.poses[body].w += Vec3<S>{dot(side.I_inverse_W_row[0], turn), dot(side.I_inverse_W_row[1], turn),
                                            dot(side.I_inverse_W_row[2], turn)};
  };
  apply(candidate.surface_body, point.surface, -impulse);
  apply(candidate.feature_body, point.feature, impulse);
}

namespace {

// Projected Gauss-Seidel, point after point, friction on a round cone, until v_n >= target wherever p_n = least, and
// p_n >= least. Residual: the last sweep's largest change of an impulse relative to the largest impulse; converged: to
// 4 eps. Where it does not converge, Newton's method goes on. False: the residual is above sqrt(eps).
template <class S>
bool solve_impulses(ImpactProblem<S>& problem, std::vector<ImpactPoint<S>>& points, int first, int count) {
  constexpr int max_sweeps = 20000;
  const auto ratio = [](S part, S whole) { return part == S(0) ? 0.0 : static_cast<double>(part / whole); };
  S change = S(0), size = S(0);
  const auto end = [&](std::int64_t sweeps, SolveEnd ended, bool usable) {
    problem.bodies.model.system().solvers.add(IterativeSolver::simultaneous_impacts,
                                              {sweeps, ratio(change, size), ended});
    return usable;
  };
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    change = size = S(0);
    for (int i = first; i < first + count; ++i) {
      ImpactPoint<S>& point = points[i];
      const Vec3<S>& n = point.kinematics.normal;
      const S friction = problem.proximity.pairs[point.pair].friction;
      const S p = real::max(point.least, point.normal_N_s - (problem.vn(point) - point.target) / point.inverse_mass_n);
      apply_impulse(problem, point, (p - point.normal_N_s) * n);
      change = real::max(change, real::abs(p - point.normal_N_s));
      point.normal_N_s = p;
      size = real::max(size, p);
      if (!(friction > S(0))) continue;
      const Vec3<S> u = problem.u(point), slip = u - dot(u, n) * n;
      Vec3<S> t = point.tangential_N_s - (S(1) / point.inverse_mass_t) * slip;
      const S length = norm(t), most = friction * p;
      if (length > most) t = (most / length) * t;
      apply_impulse(problem, point, t - point.tangential_N_s);
      change = real::max(change, norm(t - point.tangential_N_s));
      point.tangential_N_s = t;
    }
    if (!(change > S(4) * real::epsilon<S>() * size)) return end(sweep + 1, SolveEnd::converged, true);
  }
  const SolveReport newton = refine_impulses(problem, points, first, count);
  change = S(newton.residual) * size;
  return end(max_sweeps + newton.iterations,
             newton.ended == SolveEnd::converged ? SolveEnd::stagnated : SolveEnd::capped,
             change <= real::sqrt(real::epsilon<S>()) * size);
}

template <class S> void record_impulses(ImpactProblem<S>& problem, int first, int count) {
  for (int i = first; i < first + count;) {  // one event per pair
    const int pair = problem.impacts.points[i].pair;
    int end = i;
    Impulse<S> total;
    GapKinematics<S> at = problem.impacts.points[i].kinematics;
    Vec3<S> x{}, tangential{};
    S before = S(0), after = S(0);
    for (; end < first + count && problem.impacts.points[end].pair == pair; ++end) {
      const ImpactPoint<S>& point = problem.impacts.points[end];
      const S p = point.normal_N_s;
      total.normal_N_s += p;
      x += p * point.kinematics.x;
      tangential += point.tangential_N_s;
      before += p * point.before;
      after += p * problem.vn(point);
    }
    if (total.normal_N_s > S(0)) {
      at.x = (S(1) / total.normal_N_s) * x;  // where the resultant impulse acts; v_n is linear in the point
      total.vn_before_m_per_s = before / total.normal_N_s;
      total.vn_after_m_per_s = after / total.normal_N_s;
      total.tangential_N_s = norm(tangential);
      problem.impacts.applied.push_back(
          {pair, problem.candidate(problem.impacts.points[i]).feature_body == problem.proximity.pairs[pair].a, at,
           total});
    }
    i = end;
  }
}

// Impulses that do not converge, as with friction far beyond 1, are accepted if they do not add energy, and no more
// than a few times at one instant: the approach that is left belongs to the next impact.
template <class S>
bool accept_unconverged(ImpactProblem<S>& problem, const std::vector<Vec3<S>>& u_before, int first, int count) {
  constexpr int max_unconverged = 4;
  S gain = S(0), size = S(0);  // twice the work of the impulses
  for (int i = 0; i < count; ++i) {
    const ImpactPoint<S>& point = problem.impacts.points[first + i];
    const Vec3<S> impulse = point.normal_N_s * point.kinematics.normal + point.tangential_N_s;
    const S part = dot(impulse, u_before[i] + problem.u(point));
    gain += part;
    size += real::abs(part);
  }
  if (++problem.unconverged <= max_unconverged && gain <= real::sqrt(real::epsilon<S>()) * size) return true;
  problem.report.outcome = {
      Status::unsupported,
      "atwood's +event found no impulses of several contacts of one instant that obey Coulomb's law",
      0,
      0,
      {}};
  return false;
}

}  // namespace

template <class S> bool collide_simultaneously(ImpactProblem<S>& problem, int first, int count) {
  const bool newton = problem.options.restitution == Restitution::newton;
  std::vector<Vec3<S>> u_before;
  for (int i = first; i < first + count; ++i) {
    ImpactPoint<S>& point = problem.impacts.points[i];
    u_before.push_back(problem.u(point));
    const Candidate<S>& candidate = problem.candidate(point);
    const ImpactLaw<S> law = law_of(problem.proximity, problem.options, point.pair);
    point.surface = impact_body(problem.bodies, candidate.surface_body, point.kinematics.x);
    point.feature = impact_body(problem.bodies, candidate.feature_body, point.kinematics.x);
    const Vec3<S>& n = point.kinematics.normal;
    const Vec3<S> t = any_tangent(n), t2 = cross(n, t);
    point.inverse_mass_n = inverse_effective_mass(point.surface, point.feature, n);
    point.inverse_mass_t = real::max(inverse_effective_mass(point.surface, point.feature, t),
                                     inverse_effective_mass(point.surface, point.feature, t2)) +
                           real::abs(inverse_effective_mass(point.surface, point.feature, t, t2));
    point.before = problem.vn(point);
    point.normal_N_s = point.least = S(0);
    point.tangential_N_s = {};
    point.target = newton && point.before < S(0) ? -law.restitution * point.before : S(0);
  }
  bool converged = solve_impulses(problem, problem.impacts.points, first, count);
  if (!newton) {
    bool restores = false;
    for (int i = first; i < first + count; ++i) {
      ImpactPoint<S>& point = problem.impacts.points[i];
      point.least = (S(1) + law_of(problem.proximity, problem.options, point.pair).restitution) * point.normal_N_s;
      restores = restores || point.least > point.normal_N_s;
    }
    if (restores) converged = solve_impulses(problem, problem.impacts.points, first, count) && converged;
  }
  if (!converged && !accept_unconverged(problem, u_before, first, count)) return false;
  record_impulses(problem, first, count);
  return true;
}

#define ATWOOD_IMPACT_PROBLEM(S)                                                      \
  template ImpactLaw<S> law_of<S>(const Proximity<S>&, const EventOptions&, int);     \
  template void collide_point<S>(ImpactProblem<S>&, ImpactPoint<S>&);                 \
  template void apply_impulse<S>(ImpactProblem<S>&, ImpactPoint<S>&, const Vec3<S>&); \
  template bool collide_as_one_point<S>(ImpactProblem<S>&, int, int);                 \
  template bool collide_simultaneously<S>(ImpactProblem<S>&, int, int);
ATWOOD_IMPACT_PROBLEM(float)
ATWOOD_IMPACT_PROBLEM(double)
ATWOOD_IMPACT_PROBLEM(long double)
#undef ATWOOD_IMPACT_PROBLEM

}  // namespace atwood::event
