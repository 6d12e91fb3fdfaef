// All contacts of an island at once: Newton's method on the contact law with its round cone.
//
// Impulses l = (n, t, s) of every point in its own frame, relative velocities u = W l + q with W = J M^-1 J^T. The law
//   0 <= l_n  _|_  u_n + closing >= 0,
//   |l_ts| <= mu l_n, friction straight against the slip, on the cone where there is slip
// is F(l) = 0 with a step r of each row's own size (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353):
//   z = l - r (u + closing),   F_n = l_n - max(0, z_n),   F_ts = l_ts - project(z_ts, disc of radius mu max(0, z_n)).
// W is singular where a body stands on more points than it needs; Newton's matrix takes W + eps diag(W) instead, F does
// not. Rounds of Newton's step with halving; where no step is shorter, sweeps of projected Gauss-Seidel.
#include <algorithm>
#include <cmath>

#include "contact/stepping/islands.hpp"
#include "contact/stepping/points.hpp"

namespace atwood::stepping {
namespace {

// A direct solve costs as the cube of the points, so that what moves by more of them is swept unless asked otherwise.
// What rests is solved once and then stands.
constexpr int kPointsWorthIt = 32;

constexpr int kMostRounds = 20, kSweepsBetween = 8, kHalvings = 6;
constexpr double kTolerance = 1000;  // of the impulses' round-off

// Whether it is in question: a point that pushes nobody and is farther than this substep gets may be left out. Who is
// kept out wrongly, pushed by his neighbours, is seen afterwards.
template <class S> bool may_push(const World<S>& world, const Point<S>& p) {
  if (p.impulse[0] > S(0) || p.closing == S(0)) return true;
  return p.closing + S(2) * dot(velocity_at(world.bodies, p), p.n) < S(4) * norm(world.gravity_W) * world.sub_s;
}

// Points by islands, each island in the order of its points; those left out go to `d.left_out`.
template <class S> void build_islands(World<S>& world, DirectSolver<S>& d, bool all) {
  const Bodies<S>& bodies = world.bodies;
  d.parent.resize(static_cast<std::size_t>(bodies.count));
  for (int i = 0; i < bodies.count; ++i) d.parent[static_cast<std::size_t>(i)] = i;
  d.contacts.clear();
  d.left_out.clear();
  for (int contact = 0; contact < point_count(world); ++contact) {
    if (!used(world, contact)) continue;
    const auto [a, b] = bodies_of(world, contact);
    const Place at = place_of(world, contact);
    if (at.point < 0 && !(balls_at(world, at).active && balls_at(world, at).closing.lane[at.lane] < S(1e29))) continue;
    if (!all && !may_push(world, point_at(world, contact))) {
      d.left_out.push_back(contact);
      continue;
    }
    d.contacts.push_back({contact, a});
    if (!bodies.moves[b]) continue;
    join(d.parent, a, b);
  }
  for (auto& [contact, island] : d.contacts) island = root_of(d.parent, island);
  // Within an island as they come; std::stable_sort would ask for memory each time.
  std::sort(d.contacts.begin(), d.contacts.end(),
            [](const auto& x, const auto& y) { return std::pair(x.second, x.first) < std::pair(y.second, y.first); });
}

template <class S> const Vec3<S>& axis(const Point<S>& p, int c) { return c == 0 ? p.n : c == 1 ? p.t : p.s; }

// What the law makes of point i's z: its own impulse where l solves it.
template <class S> void project(const DirectSolver<S>& d, int i, const S (&z)[3], S (&out)[3]) {
  out[0] = real::max(z[0], S(0));
  const S most = d.points[i].friction * out[0], size = real::sqrt(z[1] * z[1] + z[2] * z[2]);
  const S factor = size > most ? most / size : S(1);
  out[1] = factor * z[1];
  out[2] = factor * z[2];
}

// What a unit impulse along axis c of point i does to its bodies, and how it is seen there: rows of J and of M^-1 J^T.
template <class S> void unit_impulses(const World<S>& world, DirectSolver<S>& d) {
  const Bodies<S>& bodies = world.bodies;
  d.unit.clear();
  for (const Point<S>& p : d.points)
    for (int c = 0; c < 3; ++c) {
      const Vec3<S>& along = axis(p, c);
      const Vec3<S> at_a = cross(p.arm_a, along), at_b = cross(p.arm_b, along);
      d.unit.push_back({along, at_a, at_b, turned_by(bodies.inertia[p.a], at_a), turned_by(bodies.inertia[p.b], at_b)});
    }
}

// Entry of W: a unit impulse j seen along i.
template <class S> S coupling(const World<S>& world, const DirectSolver<S>& d, int i, int j) {
  const Point<S>&p = d.points[static_cast<std::size_t>(i / 3)], &o = d.points[static_cast<std::size_t>(j / 3)];
  const UnitImpulse<S>&seen = d.unit[static_cast<std::size_t>(i)], &by = d.unit[static_cast<std::size_t>(j)];
  const auto& inertia = world.bodies.inertia;
  const S linear = dot(seen.along, by.along);
  S sum{};
  if (p.a == o.a) sum += inertia[p.a].at[6] * linear + dot(seen.at_a, by.turn_a);
  if (p.a == o.b) sum -= inertia[p.a].at[6] * linear + dot(seen.at_a, by.turn_b);
  if (p.b == o.a) sum -= inertia[p.b].at[6] * linear + dot(seen.at_b, by.turn_a);
  if (p.b == o.b) sum += inertia[p.b].at[6] * linear + dot(seen.at_b, by.turn_b);
  return sum;
}

template <class S> void report(World<S>& world, int rounds, S left, S scale, SolveEnd ended) {
  const S residual = left > S(0) ? left / scale : left;
  world.model->system().solvers.add(IterativeSolver::contact_newton, {rounds, static_cast<double>(residual), ended});
}

// The velocities there are, each row's step, and whether the impulses at hand solve the law already: then W is not
// needed.
template <class S> bool already_solved(World<S>& world, DirectSolver<S>& d) {
  const int n = d.n();
  for (auto* v : {&d.q, &d.step, &d.l, &d.z}) v->resize(static_cast<std::size_t>(3 * n));
  S scale{}, largest{};
  for (int i = 0; i < n; ++i) {
    const Vec3<S> u = velocity_at(world.bodies, d.points[i]);
    const S tt = coupling(world, d, 3 * i + 1, 3 * i + 1), ss = coupling(world, d, 3 * i + 2, 3 * i + 2),
            ts = coupling(world, d, 3 * i + 1, 3 * i + 2);
    const S larger = (tt + ss) / S(2) + real::sqrt((tt - ss) * (tt - ss) / S(4) + ts * ts);
    S z[3], law[3];
    for (int r = 0; r < 3; ++r) {
      const int row = 3 * i + r;
      d.l[row] = d.points[i].impulse[r];
      d.q[row] = dot(u, axis(d.points[i], r)) + (r == 0 ? d.points[i].closing : d.points[i].slip[r - 1]);
      d.step[row] = S(1) / (r == 0 ? coupling(world, d, row, row) : larger);
      z[r] = d.l[row] - d.step[row] * d.q[row];
      scale = real::max(scale, real::abs(d.l[row]));
    }
    project(d, i, z, law);
    for (int r = 0; r < 3; ++r) largest = real::max(largest, real::abs(d.l[3 * i + r] - law[r]));
  }
  const bool solved = largest <= S(10) * S(kTolerance) * real::epsilon<S>() * scale;  // a gap of round-off is no start
  if (solved) report(world, 0, largest, scale, SolveEnd::converged);
  return solved;
}

template <class S> void assemble(const World<S>& world, DirectSolver<S>& d) {
  const int n = d.n();
  d.W.resize(static_cast<std::size_t>(9 * n * n));
  for (int i = 0; i < 3 * n; ++i)
    for (int j = 0; j < 3 * n; ++j) d.w(i, j) = coupling(world, d, i, j);
  for (int i = 0; i < 3 * n; ++i)  // u = W l + q: what is there now came with l
    for (int j = 0; j < 3 * n; ++j) d.q[i] -= d.w(i, j) * d.l[j];
}

template <class S> S velocity_of(const DirectSolver<S>& d, int row, const std::vector<S>& l) {
  S u = d.q[row];
  const S* w = d.W.data() + static_cast<std::size_t>(row) * (3 * d.n());
  for (int j = 0; j < 3 * d.n(); ++j) u += w[j] * l[j];
  return u;
}

// F(l), and its largest entry.
template <class S>
S residual(const DirectSolver<S>& d, const std::vector<S>& l, std::vector<S>& z_out, std::vector<S>& F) {
  S largest{};
  for (int i = 0; i < d.n(); ++i) {
    S z[3], law[3];
    for (int r = 0; r < 3; ++r)
      z[r] = z_out[3 * i + r] = l[3 * i + r] - d.step[3 * i + r] * velocity_of(d, 3 * i + r, l);
    project(d, i, z, law);
    for (int r = 0; r < 3; ++r) {
      F[3 * i + r] = l[3 * i + r] - law[r];
      largest = real::max(largest, real::abs(F[3 * i + r]));
    }
  }
  return largest;
}

// One sweep of projected Gauss-Seidel, the normal first.
template <class S> void sweep(DirectSolver<S>& d) {
  for (int i = 0; i < d.n(); ++i) {
    S* l = d.l.data() + 3 * i;
    l[0] = real::max(S(0), l[0] - d.step[3 * i] * velocity_of(d, 3 * i, d.l));
    const S ut = velocity_of(d, 3 * i + 1, d.l), us = velocity_of(d, 3 * i + 2, d.l);
    const S tt = d.w(3 * i + 1, 3 * i + 1), ss = d.w(3 * i + 2, 3 * i + 2), ts = d.w(3 * i + 1, 3 * i + 2);
    const S determinant = tt * ss - ts * ts, most = d.points[i].friction * l[0];
    const S t = l[1] - (ss * ut - ts * us) / determinant, s = l[2] - (tt * us - ts * ut) / determinant;
    if (t * t + s * s <= most * most) {
      l[1] = t;
      l[2] = s;
      continue;
    }
    const S z[3] = {l[0], l[1] - d.step[3 * i + 1] * ut, l[2] - d.step[3 * i + 2] * us};
    S law[3];
    project(d, i, z, law);
    l[1] = law[1];
    l[2] = law[2];
  }
}

// The derivative of F, row by row of a point, from z.
template <class S> void fill_jacobian(DirectSolver<S>& d) {
  const int size = 3 * d.n();
  d.lu.size = size;
  if (d.lu.entry.size() < static_cast<std::size_t>(size) * size)
    d.lu.entry.resize(static_cast<std::size_t>(size) * size);
  if (d.lu.pivot.size() < static_cast<std::size_t>(size)) d.lu.pivot.resize(static_cast<std::size_t>(size));
  const S eps = real::sqrt(real::epsilon<S>());
  const auto dz = [&](int row, int column) {  // of z[row] by l[column], W with its diagonal raised
    const S one = row == column ? S(1) : S(0);
    return one - d.step[row] * (d.w(row, column) * (S(1) + eps * one));
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

// True: a step of Newton, perhaps a shorter one, made F smaller.
template <class S> bool newton(DirectSolver<S>& d, S& size) {
  fill_jacobian(d);
  d.lu.factor();
  std::copy(d.F.begin(), d.F.end(), d.change.begin());
  d.lu.solve(d.change.data());
  S part = S(1);
  for (int k = 0; k < kHalvings; ++k, part /= S(2)) {
    for (int i = 0; i < 3 * d.n(); ++i) d.l_try[i] = d.l[i] - part * d.change[i];
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

template <class S> void solve_island(World<S>& world, DirectSolver<S>& d) {
  const std::size_t size = static_cast<std::size_t>(3 * d.n());
  for (auto* v : {&d.z, &d.z_try, &d.F, &d.F_try, &d.change, &d.l_try}) v->assign(size, S(0));
  S scale{};
  for (std::size_t i = 0; i < size; ++i)
    scale = real::max(scale, real::max(real::abs(d.l[i]), d.step[i] * real::abs(d.q[i])));
  const S wanted = S(kTolerance) * real::epsilon<S>() * scale;
  S left = residual(d, d.l, d.z, d.F);
  int round = 0;
  for (; round < kMostRounds && left > wanted; ++round) {
    if (newton(d, left)) continue;
    for (int k = 0; k < kSweepsBetween; ++k) sweep(d);
    left = residual(d, d.l, d.z, d.F);
  }
  report(world, round, left, scale, left <= wanted ? SolveEnd::converged : SolveEnd::capped);
}

template <class S> void apply(World<S>& world, DirectSolver<S>& d) {
  Bodies<S>& bodies = world.bodies;
  for (int i = 0; i < d.n(); ++i) {
    Point<S>& p = d.points[i];
    Vec3<S> change{};
    for (int r = 0; r < 3; ++r) {
      change += (d.l[3 * i + r] - p.impulse[r]) * axis(p, r);
      p.impulse[r] = d.l[3 * i + r];
    }
    const auto push = [&](int body, const Vec3<S>& arm, const Vec3<S>& P) {
      if (!bodies.moves[body]) return;
      S* v = bodies.velocity[body].at;
      store3(load3(v) + bodies.inertia[body].at[6] * P, v);
      store3(load3(v + 3) + turned_by(bodies.inertia[body], cross(arm, P)), v + 3);
    };
    push(p.a, p.arm_a, -change);
    push(p.b, p.arm_b, change);
    put_impulse(world, d.numbers[i], p);
  }
}

// Newton ends within round-off of the cone; the impulses applied are in it.
template <class S> void into_cone(DirectSolver<S>& d) {
  for (int i = 0; i < d.n(); ++i) {
    const S l[3] = {d.l[3 * i], d.l[3 * i + 1], d.l[3 * i + 2]};
    S law[3];
    project(d, i, l, law);
    std::copy(law, law + 3, d.l.begin() + 3 * i);
  }
}

// Points of the largest island; in `auto` a scene is solved directly as a whole or not at all.
template <class S> int points_at_once(const World<S>& world, const DirectSolver<S>& d) {
  if (world.options.solver == Solver::automatic) return static_cast<int>(d.contacts.size());
  std::size_t most = 0;
  for (std::size_t first = 0, last = 0; first < d.contacts.size(); first = last) {
    while (last < d.contacts.size() && d.contacts[last].second == d.contacts[first].second) ++last;
    most = std::max(most, last - first);
  }
  return static_cast<int>(most);
}

template <class S> void solve_islands(World<S>& world, DirectSolver<S>& d) {
  for (std::size_t first = 0, last = 0; first < d.contacts.size(); first = last) {
    d.points.clear();
    d.numbers.clear();
    for (; last < d.contacts.size() && d.contacts[last].second == d.contacts[first].second; ++last) {
      d.points.push_back(point_at(world, d.contacts[last].first));
      d.numbers.push_back(d.contacts[last].first);
    }
    unit_impulses(world, d);
    if (already_solved(world, d)) continue;
    assemble(world, d);
    solve_island(world, d);
    into_cone(d);
    apply(world, d);
  }
}

template <class S> bool hits_somebody_left_out(const World<S>& world, const DirectSolver<S>& d) {
  for (const int contact : d.left_out) {
    const Point<S> p = point_at(world, contact);
    if (p.closing + dot(velocity_at(world.bodies, p), p.n) < S(0)) return true;
  }
  return false;
}

}  // namespace

template <class S> bool solve_directly(World<S>& world, bool rests) {
  DirectSolver<S>& d = world.direct;
  const std::size_t pairs = world.ball_pairs.size() + world.plane_pairs.size() + world.manifolds.size();
  const bool automatic = world.options.solver == Solver::automatic;
  const int most =
      automatic && !rests ? std::min(world.options.direct_points, kPointsWorthIt) : world.options.direct_points;
  if (automatic && pairs > 4 * static_cast<std::size_t>(most)) return false;
  for (const bool all : {false, true}) {
    build_islands(world, d, all);
    if (const int points = points_at_once(world, d); points > most) {
      if (world.options.solver == Solver::direct) world.refused_points = points;
      return false;
    }
    solve_islands(world, d);
    if (!hits_somebody_left_out(world, d)) break;
  }
  return true;
}

template bool solve_directly<float>(World<float>&, bool);
template bool solve_directly<double>(World<double>&, bool);

}  // namespace atwood::stepping
