// Fast approaches within a substep, one impact after another in the order of their times.
//
// Bodies move straight from where the substep finds them, p + v t. An impact at t changes v by dv, and from then on the
// body moves as if it had started from p - t dv: that shift is kept apart and added where the substep's motion is
// (drift), so an isolated impact ends where event-driven motion would, at any step, and no gap is closed by slowing
// down what should bounce.
//
// An approach no faster than the velocity that free flight itself brings within a substep is no impact but a contact
// that lasts: the sweeps over all contacts have it. So have contacts without restitution, and what is left when impacts
// never end (inelastic collapse).
#include <algorithm>

#include "contact/impulse.hpp"
#include "contact/stepping/points.hpp"
#include "math/so3.hpp"

namespace atwood::stepping {
namespace {

constexpr int kImpactsAContact = 8;  // on average, in a substep
constexpr int kMostTurns = 20;

// One body as the substep's straight motion has it.
template <class S> struct Flight { Vec3<S> p, v, w, dv; };

template <class S> Flight<S> flight(const World<S>& world, int body) {
  const Bodies<S>& bodies = world.bodies;
  if (!bodies.moves[body]) return {load3(bodies.place[body].at), {}, {}, {}};
  const S *p = bodies.place[body].at, *v = bodies.velocity[body].at, *shift = bodies.shift[body].at;
  return {load3(p) + load3(shift), load3(v), load3(v + 3), load3(bodies.kick[body].at)};
}

template <class S> struct Encounter {
  bool meets = false;
  S t_s{};
  Vec3<S> normal, arm_a, arm_b;
};

// Balls: |d + u t| = r_a + r_b.
template <class S>
Encounter<S> meeting_of_balls(const BallBatch<S>& batch, int k, const Flight<S>& a, const Flight<S>& b, S h_s) {
  Encounter<S> out;
  const S r_a = batch.radius_a.lane[k], r_b = batch.radius_b.lane[k], reach = r_a + r_b;
  const Vec3<S> d = b.p - a.p, u = b.v - a.v, fall = b.dv - a.dv;
  const S du = dot(d, u), c = dot(d, d) - reach * reach, uu = dot(u, u);
  if (!(du < S(0))) return out;
  if (c > S(0)) {
    const S discriminant = du * du - uu * c;
    if (!(discriminant > S(0))) return out;
    out.t_s = c / (-du + real::sqrt(discriminant));
    if (!(out.t_s <= h_s)) {  // not yet, unless what is added by free flight closes the rest
      const Vec3<S> end = d + h_s * (u + fall);
      if (!(dot(end, end) < reach * reach)) return out;
      out.t_s = h_s;
    }
  }
  const Vec3<S> at = d + out.t_s * u;
  const S distance = norm(at);
  if (!(distance > S(0))) return out;
  out.normal = (S(1) / distance) * at;
  const S half = (distance - reach) / S(2);  // where they overlap already, the point midway: one for both
  out.arm_a = (r_a + half) * out.normal;
  out.arm_b = -(r_b + half) * out.normal;
  out.meets = dot(u, out.normal) < -real::abs(dot(fall, out.normal));
  return out;
}

template <class S> Encounter<S> meeting_with_plane(const BallBatch<S>& batch, int k, const Flight<S>& a, S h_s) {
  Encounter<S> out;
  out.normal = lane_of(batch.normal, k);
  const S gap = -dot(out.normal, a.p) - batch.radius_a.lane[k] - batch.radius_b.lane[k];
  const S closing = dot(a.v, out.normal), fall = dot(a.dv, out.normal);
  if (!(closing > real::abs(fall))) return out;
  if (gap > S(0)) {
    out.t_s = gap / closing;
    if (out.t_s > h_s) {
      if (!(gap < h_s * (closing + fall))) return out;
      out.t_s = h_s;
    }
  }
  out.arm_a = batch.radius_a.lane[k] * out.normal;
  out.meets = true;
  return out;
}

// A point of a manifold, along the manifold's normal.
template <class S>
Encounter<S> meeting_of_point(const ManifoldBatch<S>& batch, int k, int i, const Flight<S>& a, const Flight<S>& b,
                              const Vec3<S>& moved_a, const Vec3<S>& moved_b, S h_s) {
  Encounter<S> out;
  const ManifoldPoint<S>& point = batch.point[i];
  if (!(point.gap_found.lane[k] < S(1e29))) return out;
  out.normal = lane_of(batch.normal, k);
  const Outline<S> outline_a{lane_of(batch.axis_a, k), batch.round_a.lane[k]};
  const Outline<S> outline_b{lane_of(batch.axis_b, k), batch.round_b.lane[k]};
  const auto [arm_a, arm_b, gap] =
      moved_point<S, S>(out.normal, lane_of(point.r_a, k), lane_of(point.r_b, k), point.gap_found.lane[k], b.p - a.p,
                        moved_a, moved_b, outline_a, outline_b, batch.lean.lane[k]);
  out.arm_a = arm_a;
  out.arm_b = arm_b;
  const Vec3<S> u = (b.v + cross(b.w, out.arm_b)) - (a.v + cross(a.w, out.arm_a));
  const S closing = -dot(u, out.normal), fall = -dot(b.dv - a.dv, out.normal);
  if (!(closing > real::abs(fall))) return out;
  if (gap > S(0)) {
    out.t_s = gap / closing;
    if (out.t_s > h_s) {
      if (!(gap < h_s * (closing + fall))) return out;
      out.t_s = h_s;
    }
  }
  out.meets = true;
  return out;
}

template <class S> ImpactBody<S> impact_body(const World<S>& world, int body, const Vec3<S>& arm) {
  ImpactBody<S> out;
  const Bodies<S>& bodies = world.bodies;
  if (!bodies.moves[body]) return out;
  const S *v = bodies.velocity[body].at, *I = bodies.inertia[body].at;
  out.inverse_mass_per_kg = I[6];
  out.I_inverse_W_row[0] = {I[0], I[1], I[2]};
  out.I_inverse_W_row[1] = {I[1], I[3], I[4]};
  out.I_inverse_W_row[2] = {I[2], I[4], I[5]};
  out.r_W = arm;
  out.v_W = load3(v);
  out.w_W = load3(v + 3);
  return out;
}

template <class S> void put_impact(World<S>& world, int body, const ImpactBody<S>& after, S t_s) {
  Bodies<S>& bodies = world.bodies;
  if (!bodies.moves[body]) return;
  S *v = bodies.velocity[body].at, *shift = bodies.shift[body].at;
  store3(load3(shift) - t_s * (after.v_W - load3(v)), shift);
  store3(load3(shift + 3) - t_s * (after.w_W - load3(v + 3)), shift + 3);
  store3(after.v_W, v);
  store3(after.w_W, v + 3);
}

template <class S> S restitution_of(const World<S>& world, int contact) {
  const Place at = place_of(world, contact);
  return at.point < 0 ? balls_at(world, at).restitution.lane[at.lane]
                      : manifolds_at(world, at).restitution.lane[at.lane];
}

// The next one from now_s on: what moved before is where its straight motion since then has it.
template <class S> Encounter<S> meeting_from(const World<S>& world, int contact, S now_s, S h_s) {
  const Place at = place_of(world, contact);
  const auto [a, b] = bodies_of(world, contact);
  Flight<S> fa = flight(world, a), fb = flight(world, b);
  fa.p += now_s * fa.v;
  fb.p += now_s * fb.v;
  if (at.point < 0) {
    const BallBatch<S>& batch = balls_at(world, at);
    if (world.geometry[b].kind == ShapeKind::plane) return meeting_with_plane(batch, at.lane, fa, h_s);
    return meeting_of_balls(batch, at.lane, fa, fb, h_s);
  }
  const auto turned = [&](int body) {
    if (!world.bodies.moves[body]) return Vec3<S>{};
    const Bodies<S>& all = world.bodies;
    return load3(all.place[body].at + 3) + load3(all.shift[body].at + 3) + now_s * load3(all.velocity[body].at + 3);
  };
  const ManifoldBatch<S>& batch = manifolds_at(world, at);
  const Vec3<S> moved_a = turned(a) - lane_of(batch.turned_a, at.lane),
                moved_b = turned(b) - lane_of(batch.turned_b, at.lane);
  return meeting_of_point(batch, at.lane, at.point, fa, fb, moved_a, moved_b, h_s);
}

template <class S> Encounter<S> meeting_of(const World<S>& world, int contact, S now_s, S h_s) {
  Encounter<S> out = meeting_from(world, contact, now_s, h_s - now_s);
  out.t_s += now_s;
  return out;
}

// Where the bodies' straight motion has them `t_s` into the substep.
template <class S> Placement<S> placement_at(const World<S>& world, int body, S t_s) {
  const Bodies<S>& bodies = world.bodies;
  const Flight<S> f = flight(world, body);
  if (!bodies.moves[body]) return placement(f.p, bodies.q_WB[body]);
  const Vec3<S> turned = load3(bodies.place[body].at + 3) + load3(bodies.shift[body].at + 3) + t_s * f.w;
  return placement(f.p + t_s * f.v, normalised(so3_exp(turned) * bodies.q_WB[body]));
}

// A manifold's point goes along its normal in a straight line; round and turning surfaces do not. Before an impact is
// dealt, the shapes themselves say where and when they touch: Newton on the gap of the point that is nearest to the one
// foretold. False: they do not meet within the substep.
template <class S> bool meet_on_surfaces(World<S>& world, int contact, S from_s, S sub_s, Encounter<S>& meeting) {
  const Place at = place_of(world, contact);
  if (at.point < 0) return true;  // balls and planes: exact as they are
  const auto [a, b] = bodies_of(world, contact);
  const S size = real::min(world.geometry[a].bounding_radius, world.geometry[b].bounding_radius);
  const S near_enough = S(16) * real::epsilon<S>() * size;
  auto& shapes = world.impacts.shapes;
  S gap{};
  const auto report = [&](int turns, SolveEnd ended) {
    const double residual = static_cast<double>(real::abs(gap) / size);
    world.model->system().solvers.add(IterativeSolver::impact_time, {turns, residual, ended});
  };
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const Placement<S> place_a = placement_at(world, a, meeting.t_s), place_b = placement_at(world, b, meeting.t_s);
    shapes.clear();
    find_contacts(world.geometry[a], place_a, world.geometry[b], place_b, size, shapes);
    const Vec3<S> foretold = place_a.p_W + meeting.arm_a;
    const ContactPoint<S>* point = nullptr;
    S least{};
    for (const Manifold<S>& shape : shapes)
      for (int i = 0; i < shape.count; ++i) {
        const Vec3<S> d = shape.points[i].x_W - foretold;
        if (point != nullptr && !(dot(d, d) < least)) continue;
        least = dot(d, d);
        point = &shape.points[i];
        meeting.normal = shape.normal_W;
      }
    if (point == nullptr) return false;
    meeting.arm_a = point->x_W - place_a.p_W;
    meeting.arm_b = point->x_W - place_b.p_W;
    const Flight<S> fa = flight(world, a), fb = flight(world, b);
    const auto speed = [&](const Vec3<S>& v_a, const Vec3<S>& v_b) { return -dot(v_b - v_a, meeting.normal); };
    const S closing = speed(fa.v + cross(fa.w, meeting.arm_a), fb.v + cross(fb.w, meeting.arm_b));
    if (!(closing > real::abs(speed(fa.dv, fb.dv)))) return false;
    gap = point->gap;
    if (real::abs(gap) <= near_enough) {
      report(turn + 1, SolveEnd::converged);
      return true;
    }
    const S t_s = meeting.t_s + point->gap / closing;
    if (t_s > sub_s && meeting.t_s >= sub_s) return true;  // what free flight adds closes the rest
    meeting.t_s = real::min(real::max(t_s, from_s), sub_s);
    if (t_s <= from_s && turn > 0) return true;  // overlapping already
  }
  report(kMostTurns, SolveEnd::capped);
  return true;
}

template <class S> void collide_contact(World<S>& world, int contact, const Encounter<S>& meeting, S t_s) {
  const auto [a, b] = bodies_of(world, contact);
  const Law& law = world.law(a, b);
  ImpactBody<S> left = impact_body(world, a, meeting.arm_a), right = impact_body(world, b, meeting.arm_b);
  const Vec3<S> v_before = right.inverse_mass_per_kg > S(0) ? right.v_W : left.v_W;
  const ImpactLaw<S> impact{S(law.restitution), S(law.friction), S(0), world.options.restitution};
  const Impulse<S> impulse = collide(impact, meeting.normal, left, right);
  const Vec3<S> change = right.inverse_mass_per_kg > S(0) ? (S(1) / right.inverse_mass_per_kg) * (right.v_W - v_before)
                                                          : (S(-1) / left.inverse_mass_per_kg) * (left.v_W - v_before);
  if (world.sums_impulses) {
    Told<S>& told = world.told[static_cast<std::size_t>(contact)];
    const Vec3<S> along = dot(change, meeting.normal) * meeting.normal;
    told.size += dot(change, meeting.normal);
    told.along += along;
    told.across += change - along;
  }
  if (world.observer != nullptr && world.observer->event) {
    Event event;
    const Flight<S> fa = flight(world, a);
    const Vec3<S> x = fa.p + t_s * fa.v + meeting.arm_a;
    const bool swap = a > b;
    const S sign = swap ? S(-1) : S(1);
    event.t_s = Wide(world.t_s) + Wide(t_s);
    event.kind = EventKind::impact;
    event.body_a = swap ? b : a;
    event.body_b = swap ? a : b;
    event.x_m = {Wide(x.x), Wide(x.y), Wide(x.z)};
    event.normal = {Wide(sign * meeting.normal.x), Wide(sign * meeting.normal.y), Wide(sign * meeting.normal.z)};
    event.impulse_n_N_s = Wide(impulse.normal_N_s);
    event.impulse_t_N_s = Wide(impulse.tangential_N_s);
    event.vn_before_m_per_s = Wide(impulse.vn_before_m_per_s);
    event.vn_after_m_per_s = Wide(impulse.vn_after_m_per_s);
    world.observer->event(event);
  }
  put_impact(world, a, left, t_s);
  put_impact(world, b, right, t_s);
}

template <class S> void list_contacts_of_bodies(World<S>& world, int contacts) {
  Impacts<S>& impacts = world.impacts;
  impacts.first.assign(static_cast<std::size_t>(world.bodies.count) + 2, 0);
  impacts.bouncing.clear();
  const auto each = [&](const auto& visit) {
    for (const int contact : impacts.bouncing) {
      const auto [a, b] = bodies_of(world, contact);
      if (world.bodies.moves[a]) visit(a, contact);
      if (world.bodies.moves[b]) visit(b, contact);
    }
  };
  for (int contact = 0; contact < contacts; ++contact) {
    if (!used(world, contact) || !(restitution_of(world, contact) > S(0))) continue;
    impacts.bouncing.push_back(contact);
  }
  each([&](int body, int) { ++impacts.first[body + 2]; });
  for (std::size_t i = 2; i < impacts.first.size(); ++i) impacts.first[i] += impacts.first[i - 1];
  impacts.of_body.resize(static_cast<std::size_t>(impacts.first.back()));
  each([&](int body, int contact) { impacts.of_body[static_cast<std::size_t>(impacts.first[body + 1]++)] = contact; });
}

template <class S> S approach_of(const World<S>& world, int contact, const Encounter<S>& meeting) {
  const auto [a, b] = bodies_of(world, contact);
  const Flight<S> fa = flight(world, a), fb = flight(world, b);
  return -dot((fb.v + cross(fb.w, meeting.arm_b)) - (fa.v + cross(fa.w, meeting.arm_a)), meeting.normal);
}

// By how little two instants may differ and be one: the rounding of the places over how fast the gap closes.
template <class S> S same_instant(const World<S>& world, int contact, S approach, S sub_s) {
  const auto [a, b] = bodies_of(world, contact);
  const auto size = [&](int body) {
    const S own = world.geometry[body].kind == ShapeKind::plane ? real::abs(world.geometry[body].offset)
                                                                : world.geometry[body].bounding_radius;
    return norm(load3(world.bodies.place[body].at)) + own;
  };
  return S(16) * real::epsilon<S>() * (sub_s + (size(a) + size(b)) / approach);
}

// Of the impacts of this instant, where the scene asks for them one after another: the fastest approach, ties in the
// order of the bodies. The others go back into the queue.
template <class S, class Later>
void take_fastest(World<S>& world, S now_s, S sub_s, const Later& later, Approach<S>& next, Encounter<S>& meeting) {
  auto& queue = world.impacts.queue;
  auto& tied = world.impacts.tied;
  tied.clear();
  S fastest = approach_of(world, next.contact, meeting);
  const S until_s = meeting.t_s + same_instant(world, next.contact, fastest, sub_s);
  const auto order = [&](int contact) {
    const auto [a, b] = bodies_of(world, contact);
    return std::pair(std::min(a, b), std::max(a, b));
  };
  while (!queue.empty() && queue.front().t_s <= until_s) {
    std::pop_heap(queue.begin(), queue.end(), later);
    const Approach<S> other = queue.back();
    queue.pop_back();
    const Encounter<S> its = meeting_of(world, other.contact, now_s, sub_s);
    if (!its.meets || other.contact == next.contact) continue;
    const S approach = approach_of(world, other.contact, its), alike = S(64) * real::epsilon<S>() * fastest;
    const bool comes_first = approach >= fastest - alike && order(other.contact) < order(next.contact);
    const bool earlier = its.t_s <= until_s && (approach > fastest + alike || comes_first);
    tied.push_back(earlier ? Approach<S>{meeting.t_s, next.contact} : Approach<S>{its.t_s, other.contact});
    if (!earlier) continue;
    next = other;
    meeting = its;
    fastest = approach;
  }
  for (const Approach<S>& other : tied) {
    queue.push_back(other);
    std::push_heap(queue.begin(), queue.end(), later);
  }
}

}  // namespace

template <class S> void list_bouncing(World<S>& world) {
  if (!world.bounces) return;
  list_contacts_of_bodies(world, point_count(world));
}

template <class S> void meet_impacts(World<S>& world, S sub_s) {
  if (!world.bounces) return;
  Impacts<S>& impacts = world.impacts;
  auto& queue = impacts.queue;
  queue.clear();
  const auto later = [](const Approach<S>& x, const Approach<S>& y) {
    return x.t_s != y.t_s ? x.t_s > y.t_s : x.contact > y.contact;
  };
  S now_s{};
  const bool one_by_one = world.scene->simultaneous_impacts == SimultaneousImpacts::sequential;
  const auto watch = [&](int contact) {
    const Encounter<S> meeting = meeting_of(world, contact, now_s, sub_s);
    if (!meeting.meets) return;
    queue.push_back({meeting.t_s, contact});
    std::push_heap(queue.begin(), queue.end(), later);
  };
  for (const int contact : impacts.bouncing) watch(contact);
  const std::size_t most = impacts.bouncing.size() * kImpactsAContact;
  std::size_t n = 0;
  for (; !queue.empty() && n < most; ++n) {
    std::pop_heap(queue.begin(), queue.end(), later);
    Approach<S> next = queue.back();
    queue.pop_back();
    Encounter<S> meeting = meeting_of(world, next.contact, now_s, sub_s);
    if (!meeting.meets) continue;                             // an impact since then changed it
    if (!queue.empty() && meeting.t_s > queue.front().t_s) {  // it has become later: back into the order
      queue.push_back({meeting.t_s, next.contact});
      std::push_heap(queue.begin(), queue.end(), later);
      continue;
    }
    if (one_by_one) take_fastest(world, now_s, sub_s, later, next, meeting);
    if (!meet_on_surfaces(world, next.contact, now_s, sub_s, meeting)) continue;
    now_s = meeting.t_s;
    collide_contact(world, next.contact, meeting, now_s);
    const auto [a, b] = bodies_of(world, next.contact);
    for (const int body : {a, b}) {
      if (!world.bodies.moves[body]) continue;
      for (int i = impacts.first[body]; i < impacts.first[body + 1]; ++i)
        watch(impacts.of_body[static_cast<std::size_t>(i)]);
    }
  }
  if (n == 0) return;
  const double left = static_cast<double>(queue.size()) / static_cast<double>(impacts.bouncing.size());
  world.model->system().solvers.add(
      IterativeSolver::impact_queue,
      {static_cast<std::int64_t>(n), left, queue.empty() ? SolveEnd::converged : SolveEnd::capped});
}

#define ATWOOD_IMPACTS(S)                    \
  template void list_bouncing<S>(World<S>&); \
  template void meet_impacts<S>(World<S>&, S);
ATWOOD_IMPACTS(float)
ATWOOD_IMPACTS(double)
#undef ATWOOD_IMPACTS

}  // namespace atwood::stepping
