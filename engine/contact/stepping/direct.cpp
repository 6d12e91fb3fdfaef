// Direct solver: all contacts of an island at once, by Newton's method on the contact law with the round friction cone.
//
// Impulses l = (n, t, s) of every point in its own frame, relative velocities u = W l + q with W = J M^-1 J^T. The law
//   0 <= l_n  _|_  u_n + bias >= 0,
//   |l_ts| <= mu l_n, friction opposite to the slip, on the cone where there is slip
// is F(l) = 0 with a step r of each row's own size (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353):
//   z = l - r (u + bias),   F_n = l_n - max(0, z_n),   F_ts = l_ts - project(z_ts, disc of radius mu max(0, z_n)).
// W is singular where the contact points of a body are redundant (hyperstatic contact). Newton's matrix therefore uses
// W + eps diag(W); F does not. Each Newton step is halved until it reduces F; where no length of it does, sweeps of
// projected Gauss-Seidel follow.
#include <algorithm>
#include <cmath>

#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "scene/union_find.hpp"

namespace atwood::stepping {
namespace {

// The cost of a direct solve is cubic in the number of points. With solver=auto a scene in motion, without joints, that
// has more points than this is solved by sweeps. To a scene at rest only `direct_points` applies: after its first solve
// the warm start is the solution.
constexpr int kMaxPointsInMotion = 32;

constexpr int kMaxNewtonIterations = 20, kFallbackSweeps = 8, kMaxStepHalvings = 6;
constexpr double kTolerance = 1000;  // of the residual, in units of the impulses' round-off

// False: the point carries no impulse, and its gap cannot close in this substep at the present velocities. Such a point
// is left out; approaches_inactive_contact() checks after the solve whether its neighbours' impulses close it.
template <class S> bool may_become_active(const World<S>& world, const SolverPoint<S>& p) {
  if (p.impulse[0] > S(0) || p.bias == S(0)) return true;
  return p.bias + S(2) * dot(relative_velocity(world.bodies, p), p.n) < S(4) * norm(world.gravity_W) * world.sub_s;
}

// The child body of a stop's joint; it always moves.
template <class S> int tied_child(const World<S>& world, std::size_t stop) {
  return world.scene->joints[static_cast<std::size_t>(world.tied->stops[stop].joint)].child;
}

// The solver's point of a contact; -1 - s stands for stop s.
template <class S> SolverPoint<S> point_of(const World<S>& world, int contact) {
  if (contact >= 0) return solver_point(world, contact);
  const StopConstraint<S>& stop = world.tied->stops[static_cast<std::size_t>(-1 - contact)];
  SolverPoint<S> out;
  out.a = out.b = tied_child(world, static_cast<std::size_t>(-1 - contact));
  out.bias = stop.bias;
  out.impulse[0] = stop.impulse;
  return out;
}

// Sets d.contacts to the contacts by islands, within an island in their own order, and d.inactive to those left out.
// `all`: none is left out.
template <class S> void build_islands(World<S>& world, DirectSolver<S>& d, bool all) {
  const BodyRows<S>& bodies = world.bodies;
  d.parent.resize(static_cast<std::size_t>(bodies.count));
  for (int i = 0; i < bodies.count; ++i) d.parent[static_cast<std::size_t>(i)] = i;
  d.contacts.clear();
  d.inactive.clear();
  if (world.tied != nullptr)
    for (const Mechanism<S>& mechanism : world.tied->mechanisms)
      for (const int body : mechanism.bodies) unite(d.parent, mechanism.bodies.front(), body);
  for (int contact = 0; contact < point_count(world); ++contact) {
    if (!is_contact(world, contact)) continue;
    const auto [a, b] = bodies_of(world, contact);
    const ContactAddress at = address_of(world, contact);
    if (at.point < 0 && !(sphere_batch(world, at).active && sphere_batch(world, at).bias.lane[at.lane] < S(kMaxValue)))
      continue;
    if (!all && !may_become_active(world, solver_point(world, contact))) {
      d.inactive.push_back(contact);
      continue;
    }
    d.contacts.push_back({contact, a});
    if (!bodies.moves[b]) continue;
    unite(d.parent, a, b);
  }
  for (std::size_t s = 0; world.tied != nullptr && s < world.tied->stops.size(); ++s)
    if (world.tied->stops[s].mobility > S(0)) d.contacts.push_back({-1 - static_cast<int>(s), tied_child(world, s)});
  for (auto& [contact, island] : d.contacts) island = find_root(d.parent, island);
  // std::stable_sort would allocate each time
  std::sort(d.contacts.begin(), d.contacts.end(),
            [](const auto& x, const auto& y) { return std::pair(x.second, x.first) < std::pair(y.second, y.first); });
}

template <class S> const Vec3<S>& axis(const SolverPoint<S>& p, int c) { return c == 0 ? p.n : c == 1 ? p.t : p.s; }

// The projection of z at point i onto the cone; it equals l where l solves the contact law.
template <class S> void project(const DirectSolver<S>& d, int i, const S (&z)[3], S (&out)[3]) {
  out[0] = real::max(z[0], S(0));
  const S most = d.points[i].friction * out[0], size = real::sqrt(z[1] * z[1] + z[2] * z[2]);
  const S factor = size > most ? most / size : S(1);
  out[1] = factor * z[1];
  out[2] = factor * z[2];
}

// Sets d.jacobian: the rows n, t and s of each point.
template <class S> void compute_jacobian(const World<S>& world, DirectSolver<S>& d) {
  const BodyRows<S>& bodies = world.bodies;
  d.jacobian.clear();
  for (const SolverPoint<S>& p : d.points)
    for (int c = 0; c < 3; ++c) {
      const Vec3<S>& along = axis(p, c);
      const Vec3<S> at_a = cross(p.arm_a, along), at_b = cross(p.arm_b, along);
      d.jacobian.push_back({along, at_a, at_b, apply_inverse_inertia(bodies.inertia[p.a], at_a),
                            apply_inverse_inertia(bodies.inertia[p.b], at_b)});
    }
}

// Sets d.tied: what each row's impulse does to mechanisms.
template <class S> void compute_tied_responses(World<S>& world, DirectSolver<S>& d) {
  d.tied.clear();
  if (world.tied == nullptr) return;
  d.tied.resize(6 * d.points.size());
  const auto begin = [&](TiedResponse<S>& response, int body) {
    response.mechanism = world.tied->mechanism_of[static_cast<std::size_t>(body)];
    if (response.mechanism >= 0)
      response.z.assign(world.tied->mechanisms[static_cast<std::size_t>(response.mechanism)].z.size(), S(0));
  };
  for (std::size_t i = 0; i < d.points.size(); ++i) {
    const SolverPoint<S>& p = d.points[i];
    if (d.contact_of_point[i] < 0) {
      d.tied[6 * i] = stop_response(world, world.tied->stops[static_cast<std::size_t>(-1 - d.contact_of_point[i])]);
      continue;
    }
    for (std::size_t r = 3 * i; r < 3 * i + 3; ++r) {
      TiedResponse<S>&of_a = d.tied[2 * r], &of_b = d.tied[2 * r + 1];
      const JacobianRow<S>& row = d.jacobian[r];
      begin(of_a, p.a);
      if (of_a.mechanism >= 0) add_to_response(world, p.a, -row.direction, -row.moment_a, of_a);
      const bool same =
          is_tied(world, p.b) && world.tied->mechanism_of[static_cast<std::size_t>(p.b)] == of_a.mechanism;
      if (!same) begin(of_b, p.b);
      if (is_tied(world, p.b)) add_to_response(world, p.b, row.direction, row.moment_b, same ? of_a : of_b);
      project_response(world, of_a);
      project_response(world, of_b);
    }
  }
}

// Sets d.mechanisms to those that the rows act on.
template <class S> void list_mechanisms(DirectSolver<S>& d) {
  d.mechanisms.clear();
  for (const TiedResponse<S>& response : d.tied)
    if (response.mechanism >= 0) d.mechanisms.push_back(response.mechanism);
  std::sort(d.mechanisms.begin(), d.mechanisms.end());
  d.mechanisms.erase(std::unique(d.mechanisms.begin(), d.mechanisms.end()), d.mechanisms.end());
}

// The part of an entry of W that mechanisms contribute.
template <class S> S tied_entry(const DirectSolver<S>& d, int i, int j) {
  S sum{};
  for (std::size_t k = 2 * static_cast<std::size_t>(i); k < 2 * static_cast<std::size_t>(i) + 2; ++k)
    for (std::size_t l = 2 * static_cast<std::size_t>(j); l < 2 * static_cast<std::size_t>(j) + 2; ++l) {
      if (d.tied[k].mechanism < 0 || d.tied[k].mechanism != d.tied[l].mechanism) continue;
      for (std::size_t c = 0; c < d.tied[k].z.size(); ++c) sum += d.tied[k].z[c] * d.tied[l].z[c];
    }
  return sum;
}

// Calls add(sign, inverse mass, moments of the rows of i, rates of the rows of j) for each body without joints that
// points i and j share: what the body contributes to the rows of i and columns of j of W.
template <class S, class Add>
void over_shared_bodies(const World<S>& world, const DirectSolver<S>& d, int i, int j, const Add& add) {
  const SolverPoint<S>&p = d.points[static_cast<std::size_t>(i)], &o = d.points[static_cast<std::size_t>(j)];
  using Row = JacobianRow<S>;
  const auto over = [&](int of_i, int of_j, S sign, Vec3<S> Row::*moment, Vec3<S> Row::*rate) {
    if (of_i != of_j || (!d.tied.empty() && is_tied(world, of_i))) return;
    add(sign, world.bodies.inertia[of_i].at[6], moment, rate);
  };
  over(p.a, o.a, S(1), &Row::moment_a, &Row::rate_a);
  over(p.a, o.b, S(-1), &Row::moment_a, &Row::rate_b);
  over(p.b, o.a, S(-1), &Row::moment_b, &Row::rate_a);
  over(p.b, o.b, S(1), &Row::moment_b, &Row::rate_b);
}

// The part of an entry of W that bodies without joints contribute.
template <class S> S free_entry(const World<S>& world, const DirectSolver<S>& d, int i, int j) {
  const JacobianRow<S>&row = d.jacobian[static_cast<std::size_t>(i)], &column = d.jacobian[static_cast<std::size_t>(j)];
  S sum{};
  over_shared_bodies(world, d, i / 3, j / 3, [&](S sign, S inverse_mass, auto moment, auto rate) {
    sum += sign * (inverse_mass * dot(row.direction, column.direction) + dot(row.*moment, column.*rate));
  });
  return sum;
}

// Entry (i, j) of the Delassus matrix W = J M^-1 J^T; with joints, M^-1 is projected onto the motions that they allow.
// A stop's rows t and s, which no impulse has, are given the diagonal 1.
template <class S> S delassus_entry(const World<S>& world, const DirectSolver<S>& d, int i, int j) {
  if (!d.tied.empty()) {
    const bool stop = d.contact_of_point[static_cast<std::size_t>(i / 3)] < 0;
    if (stop && i % 3 != 0) return i == j ? S(1) : S(0);
    return tied_entry(d, i, j) + free_entry(world, d, i, j);
  }
  return free_entry(world, d, i, j);
}

template <class S> StopConstraint<S>& stop_of(World<S>& world, const DirectSolver<S>& d, int i) {
  return world.tied->stops[static_cast<std::size_t>(-1 - d.contact_of_point[static_cast<std::size_t>(i)])];
}

// Adds a solve to the run's tallies; `left` is the residual, an impulse.
template <class S> void report(World<S>& world, int iterations, S left, S scale, SolveEnd ended) {
  const S residual = left > S(0) ? left / scale : left;
  world.model->system().solvers.add(IterativeSolver::contact_newton,
                                    {iterations, static_cast<double>(residual), ended});
}

// Sets d.l to the impulses of the warm start, d.q to the relative velocities with them, and d.row_step. True: these
// impulses solve the contact law already, and W is not needed.
template <class S> bool satisfies_contact_law(World<S>& world, DirectSolver<S>& d) {
  const int n = d.n();
  for (auto* v : {&d.q, &d.row_step, &d.l, &d.z}) v->resize(static_cast<std::size_t>(3 * n));
  S scale{}, largest{};
  for (int i = 0; i < n; ++i) {
    const bool stop = d.contact_of_point[i] < 0;
    const Vec3<S> u = stop ? Vec3<S>{} : relative_velocity(world.bodies, d.points[i]);
    const S tt = delassus_entry(world, d, 3 * i + 1, 3 * i + 1), ss = delassus_entry(world, d, 3 * i + 2, 3 * i + 2),
            ts = delassus_entry(world, d, 3 * i + 1, 3 * i + 2);
    const S larger = (tt + ss) / S(2) + real::sqrt((tt - ss) * (tt - ss) / S(4) + ts * ts);
    S z[3], law[3];
    for (int r = 0; r < 3; ++r) {
      const int row = 3 * i + r;
      d.l[row] = d.points[i].impulse[r];
      d.q[row] = dot(u, axis(d.points[i], r)) + (r == 0 ? d.points[i].bias : d.points[i].surface_velocity[r - 1]);
      if (stop && r == 0) d.q[row] += rate_of(world, stop_of(world, d, i).row);
      d.row_step[row] = S(1) / (r == 0 ? delassus_entry(world, d, row, row) : larger);
      z[r] = d.l[row] - d.row_step[row] * d.q[row];
      scale = real::max(scale, real::abs(d.l[row]));
    }
    project(d, i, z, law);
    for (int r = 0; r < 3; ++r) largest = real::max(largest, real::abs(d.l[3 * i + r] - law[r]));
  }
  const bool solved =
      largest <= S(10) * S(kTolerance) * real::epsilon<S>() * scale;  // ten times the tolerance of a solve
  if (solved) report(world, 0, largest, scale, SolveEnd::converged);
  return solved;
}

// Adds to the nine entries of W of points i and j what bodies without joints contribute.
template <class S> void add_free_entries(const World<S>& world, DirectSolver<S>& d, int i, int j) {
  over_shared_bodies(world, d, i, j, [&](S sign, S inverse_mass, auto moment, auto rate) {
    for (int r = 3 * i; r < 3 * i + 3; ++r)
      for (int c = 3 * j; c < 3 * j + 3; ++c) {
        const JacobianRow<S>&row = d.jacobian[static_cast<std::size_t>(r)],
              &column = d.jacobian[static_cast<std::size_t>(c)];
        d.w(r, c) += sign * (inverse_mass * dot(row.direction, column.direction) + dot(row.*moment, column.*rate));
      }
  });
}

// Sets d.W, and d.q to the velocities without contact impulses.
template <class S> void assemble(const World<S>& world, DirectSolver<S>& d) {
  const int n = d.n();
  d.W.assign(static_cast<std::size_t>(9 * n * n), S(0));
  if (d.tied.empty()) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) add_free_entries(world, d, i, j);
  } else {
    for (int i = 0; i < 3 * n; ++i)
      for (int j = 0; j < 3 * n; ++j) d.w(i, j) = delassus_entry(world, d, i, j);
  }
  for (int i = 0; i < 3 * n; ++i)  // u = W l + q, and d.q was u
    for (int j = 0; j < 3 * n; ++j) d.q[i] -= d.w(i, j) * d.l[j];
}

// Row `row` of u = W l + q.
template <class S> S velocity_of(const DirectSolver<S>& d, int row, const std::vector<S>& l) {
  S u = d.q[row];
  const S* w = d.W.data() + static_cast<std::size_t>(row) * (3 * d.n());
  for (int j = 0; j < 3 * d.n(); ++j) u += w[j] * l[j];
  return u;
}

// Sets z_out and F to z and F(l); returns the largest |F|, N s.
template <class S>
S residual(const DirectSolver<S>& d, const std::vector<S>& l, std::vector<S>& z_out, std::vector<S>& F) {
  S largest{};
  for (int i = 0; i < d.n(); ++i) {
    S z[3], law[3];
    for (int r = 0; r < 3; ++r)
      z[r] = z_out[3 * i + r] = l[3 * i + r] - d.row_step[3 * i + r] * velocity_of(d, 3 * i + r, l);
    project(d, i, z, law);
    for (int r = 0; r < 3; ++r) {
      F[3 * i + r] = l[3 * i + r] - law[r];
      largest = real::max(largest, real::abs(F[3 * i + r]));
    }
  }
  return largest;
}

// One sweep of projected Gauss-Seidel over the points, at each the normal impulse first. Changes d.l.
template <class S> void sweep(DirectSolver<S>& d) {
  for (int i = 0; i < d.n(); ++i) {
    S* l = d.l.data() + 3 * i;
    l[0] = real::max(S(0), l[0] - d.row_step[3 * i] * velocity_of(d, 3 * i, d.l));
    const S ut = velocity_of(d, 3 * i + 1, d.l), us = velocity_of(d, 3 * i + 2, d.l);
    const S tt = d.w(3 * i + 1, 3 * i + 1), ss = d.w(3 * i + 2, 3 * i + 2), ts = d.w(3 * i + 1, 3 * i + 2);
    const S determinant = tt * ss - ts * ts, most = d.points[i].friction * l[0];
    const S t = l[1] - (ss * ut - ts * us) / determinant, s = l[2] - (tt * us - ts * ut) / determinant;
    if (t * t + s * s <= most * most) {
      l[1] = t;
      l[2] = s;
      continue;
    }
    const S z[3] = {l[0], l[1] - d.row_step[3 * i + 1] * ut, l[2] - d.row_step[3 * i + 2] * us};
    S law[3];
    project(d, i, z, law);
    l[1] = law[1];
    l[2] = law[2];
  }
}

// Sets d.lu to the derivative of F by l at d.z, with W + eps diag(W) in place of W.
template <class S> void compute_residual_jacobian(DirectSolver<S>& d) {
  const int size = 3 * d.n();
  d.lu.size = size;
  if (d.lu.entry.size() < static_cast<std::size_t>(size) * size)
    d.lu.entry.resize(static_cast<std::size_t>(size) * size);
  if (d.lu.pivot.size() < static_cast<std::size_t>(size)) d.lu.pivot.resize(static_cast<std::size_t>(size));
  const S eps = real::sqrt(real::epsilon<S>());
  const auto dz = [&](int row, int column) {  // dz[row] / dl[column]
    const S one = row == column ? S(1) : S(0);
    return one - d.row_step[row] * (d.w(row, column) * (S(1) + eps * one));
  };
  for (int i = 0; i < d.n(); ++i) {
    const S* z = d.z.data() + 3 * i;
    const S most = d.points[i].friction * real::max(z[0], S(0)), slip_z = real::sqrt(z[1] * z[1] + z[2] * z[2]);
    const bool slips = slip_z > most;
    const S e[2] = {slips ? z[1] / slip_z : S(0), slips ? z[2] / slip_z : S(0)}, factor = slips ? most / slip_z : S(1);
    for (int j = 0; j < size; ++j) {
      const S dn = z[0] > S(0) ? dz(3 * i, j) : S(0);
      d.lu.at(3 * i, j) = (j == 3 * i ? S(1) : S(0)) - dn;
      const S along = e[0] * dz(3 * i + 1, j) + e[1] * dz(3 * i + 2, j);
      for (int r = 0; r < 2; ++r) {
        const S across = factor * (dz(3 * i + 1 + r, j) - e[r] * along);
        d.lu.at(3 * i + 1 + r, j) = (j == 3 * i + 1 + r ? S(1) : S(0)) - across - e[r] * d.points[i].friction * dn;
      }
    }
  }
}

// Newton's step with a line search by halving. True: a step reduced F, and d.l, d.z, d.F and `size`, the largest |F|,
// are those after it; false: nothing changed.
template <class S> bool newton_step(DirectSolver<S>& d, S& size) {
  compute_residual_jacobian(d);
  d.lu.factor();
  std::copy(d.F.begin(), d.F.end(), d.newton_step.begin());
  d.lu.solve(d.newton_step.data());
  S length = S(1);
  for (int k = 0; k < kMaxStepHalvings; ++k, length /= S(2)) {
    for (int i = 0; i < 3 * d.n(); ++i) d.l_try[i] = d.l[i] - length * d.newton_step[i];
    const S now = residual(d, d.l_try, d.z_try, d.F_try);
    if (!(now < S(0.9) * size)) continue;
    d.l.swap(d.l_try);
    d.z.swap(d.z_try);
    d.F.swap(d.F_try);
    size = now;
    return true;
  }
  return false;
}

// Iterates d.l to the tolerance, or to the last iteration.
template <class S> void solve_island(World<S>& world, DirectSolver<S>& d) {
  const std::size_t size = static_cast<std::size_t>(3 * d.n());
  for (auto* v : {&d.z, &d.z_try, &d.F, &d.F_try, &d.newton_step, &d.l_try}) v->assign(size, S(0));
  S scale{};
  for (std::size_t i = 0; i < size; ++i)
    scale = real::max(scale, real::max(real::abs(d.l[i]), d.row_step[i] * real::abs(d.q[i])));
  const S tolerance_N_s = S(kTolerance) * real::epsilon<S>() * scale;
  S left = residual(d, d.l, d.z, d.F);
  int iterations = 0;
  for (; iterations < kMaxNewtonIterations && left > tolerance_N_s; ++iterations) {
    if (newton_step(d, left)) continue;
    for (int k = 0; k < kFallbackSweeps; ++k) sweep(d);
    left = residual(d, d.l, d.z, d.F);
  }
  report(world, iterations, left, scale, left <= tolerance_N_s ? SolveEnd::converged : SolveEnd::capped);
}

// Applies the change of the impulses to the bodies and stores them. Changes velocities and impulses.
template <class S> void apply(World<S>& world, DirectSolver<S>& d) {
  BodyRows<S>& bodies = world.bodies;
  for (int i = 0; i < d.n(); ++i) {
    SolverPoint<S>& p = d.points[i];
    if (d.contact_of_point[i] < 0) {
      StopConstraint<S>& stop = stop_of(world, d, i);
      apply_row(world, stop.row, d.l[3 * i] - stop.impulse);
      stop.impulse = d.l[3 * i];
      continue;
    }
    Vec3<S> change{};
    for (int r = 0; r < 3; ++r) {
      change += (d.l[3 * i + r] - p.impulse[r]) * axis(p, r);
      p.impulse[r] = d.l[3 * i + r];
    }
    const auto apply_to = [&](int body, const Vec3<S>& arm, const Vec3<S>& P) {
      if (!bodies.moves[body]) return;
      S* v = bodies.velocity[body].at;
      store3(load3(v) + bodies.inertia[body].at[6] * P, v);
      store3(load3(v + 3) + apply_inverse_inertia(bodies.inertia[body], cross(arm, P)), v + 3);
    };
    apply_to(p.a, p.arm_a, -change);
    apply_to(p.b, p.arm_b, change);
    store_impulse(world, d.contact_of_point[i], p);
  }
  for (const int mechanism : d.mechanisms)
    satisfy_joints(world, world.tied->mechanisms[static_cast<std::size_t>(mechanism)]);
}

// Projects d.l into the cone, which Newton's method meets to round-off only.
template <class S> void project_into_cone(DirectSolver<S>& d) {
  for (int i = 0; i < d.n(); ++i) {
    const S l[3] = {d.l[3 * i], d.l[3 * i + 1], d.l[3 * i + 2]};
    S law[3];
    project(d, i, l, law);
    std::copy(law, law + 3, d.l.begin() + 3 * i);
  }
}

// Points of the largest island; with solver=auto, of all: it solves a scene directly as a whole or not at all.
template <class S> int largest_problem(const World<S>& world, const DirectSolver<S>& d) {
  if (world.options.solver == Solver::automatic) return static_cast<int>(d.contacts.size());
  std::size_t most = 0;
  for (std::size_t first = 0, last = 0; first < d.contacts.size(); first = last) {
    while (last < d.contacts.size() && d.contacts[last].second == d.contacts[first].second) ++last;
    most = std::max(most, last - first);
  }
  return static_cast<int>(most);
}

// Solves each island, unless its warm start is the solution, and applies the impulses.
template <class S> void solve_islands(World<S>& world, DirectSolver<S>& d) {
  for (std::size_t first = 0, last = 0; first < d.contacts.size(); first = last) {
    d.points.clear();
    d.contact_of_point.clear();
    for (; last < d.contacts.size() && d.contacts[last].second == d.contacts[first].second; ++last) {
      d.points.push_back(point_of(world, d.contacts[last].first));
      d.contact_of_point.push_back(d.contacts[last].first);
    }
    compute_jacobian(world, d);
    compute_tied_responses(world, d);
    list_mechanisms(d);
    if (satisfies_contact_law(world, d)) continue;
    assemble(world, d);
    solve_island(world, d);
    project_into_cone(d);
    apply(world, d);
  }
}

// True: a contact that was left out closes its gap after all.
template <class S> bool approaches_inactive_contact(const World<S>& world, const DirectSolver<S>& d) {
  for (const int contact : d.inactive) {
    const SolverPoint<S> p = solver_point(world, contact);
    if (p.bias + dot(relative_velocity(world.bodies, p), p.n) < S(0)) return true;
  }
  return false;
}

}  // namespace

template <class S> bool solve_directly(World<S>& world, bool at_rest) {
  DirectSolver<S>& d = world.direct;
  const std::size_t pairs =
      world.candidates.sphere_pairs.size() + world.candidates.plane_pairs.size() + world.manifolds.size();
  const bool automatic = world.options.solver == Solver::automatic;
  const int most = automatic && !at_rest && world.tied == nullptr
                       ? std::min(world.options.direct_points, kMaxPointsInMotion)
                       : world.options.direct_points;
  if (automatic && pairs > 4 * static_cast<std::size_t>(most)) return false;
  for (const bool all : {false, true}) {
    build_islands(world, d, all);
    if (const int points = largest_problem(world, d); points > most) {
      if (world.options.solver == Solver::direct) world.end.points_beyond_limit = points;
      return false;
    }
    solve_islands(world, d);
    if (!approaches_inactive_contact(world, d)) break;
  }
  return true;
}

template bool solve_directly<float>(World<float>&, bool);
template bool solve_directly<double>(World<double>&, bool);

}  // namespace atwood::stepping
