// Impacts within a substep: fast approaches of contacts with restitution, resolved one after another in the order
// of their times.
//
// Between impacts the bodies move uniformly from where the substep begins, p + v t. An impact at t changes v by dv, and
// from then on the body moves as if it had started from p - t dv. That displacement is kept in BodyRows::impact_shift
// and added when the positions are advanced, so an isolated impact ends where event-driven motion would put it, with
// any step, and no approach is slowed down to close the gap.
//
// An approach that is no faster than the velocity increment of a substep is a lasting contact and left to the velocity
// solver. So are contacts without restitution and, after inelastic collapse, the approaches that are left at the limit:
// kMaxLossPerContact impacts a contact on average, where one of restitution e counts as 2 (1 - e), at most 1. Those of
// restitution 1 therefore do not count, as long as the time advances.
#include <algorithm>
#include <limits>

#include "contact/impulse.hpp"
#include "contact/stepping/contact_points.hpp"
#include "contact/stepping/impact_prediction.hpp"
#include "contact/stepping/mechanisms.hpp"
#include "math/so3.hpp"

namespace atwood::stepping {
namespace {

constexpr int kMaxLossPerContact = 8;  // on average, in a substep, in units of loss_by()
constexpr int kMaxImpactsPerStop = 8;  // on average, in a substep
constexpr int kMaxRefinements = 20;    // Newton iterations of refine_on_surfaces()

// Impacts that follow each other without the time advancing: at least the first number, and the second per contact.
constexpr std::size_t kMaxImpactsAtAnInstant = 10000, kMaxImpactsAtAnInstantPerContact = 1000;

template <class S> ImpactBody<S> impact_body(const World<S>& world, int body, const Vec3<S>& arm) {
  ImpactBody<S> out;
  const BodyRows<S>& bodies = world.bodies;
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

// Sets the velocities after an impact at t_s, and adds to the impact shift, so that the motion starts from the place of
// the impact.
template <class S> void set_velocity_after_impact(World<S>& world, int body, const ImpactBody<S>& after, S t_s) {
  BodyRows<S>& bodies = world.bodies;
  if (!bodies.moves[body]) return;
  S *v = bodies.velocity[body].at, *shift = bodies.impact_shift[body].at;
  store3(load3(shift) - t_s * (after.v_W - load3(v)), shift);
  store3(load3(shift + 3) - t_s * (after.w_W - load3(v + 3)), shift + 3);
  store3(after.v_W, v);
  store3(after.w_W, v + 3);
}

template <class S> S restitution_of(const World<S>& world, int contact) {
  const ContactAddress at = address_of(world, contact);
  return at.point < 0 ? sphere_batch(world, at).restitution.lane[at.lane]
                      : manifold_batch(world, at).restitution.lane[at.lane];
}

// The body's transform at t_s of the substep.
template <class S> Transform<S> transform_at(const World<S>& world, int body, S t_s) {
  const BodyRows<S>& bodies = world.bodies;
  const LinearMotion<S> f = linear_motion(world, body);
  if (!bodies.moves[body]) return transform(f.p, bodies.q_WB[body]);
  const Vec3<S> rotation = load3(bodies.pose[body].at + 3) + load3(bodies.impact_shift[body].at + 3) + t_s * f.w;
  return transform(f.p + t_s * f.v, normalised(so3_exp(rotation) * bodies.q_WB[body]));
}

// predict_point_impact() moves a point along the normal of detection, which is exact only for corners on planes. Before
// such an impact is resolved, Newton's method on the gap between the shapes, at the contact point nearest to the
// predicted one, corrects its time, normal and arms. False: the shapes do not touch within the substep.
template <class S> bool refine_on_surfaces(World<S>& world, int contact, S from_s, PredictedImpact<S>& predicted) {
  const ContactAddress at = address_of(world, contact);
  if (at.point < 0) return true;  // spheres and planes: exact
  const auto [a, b] = bodies_of(world, contact);
  const S size = real::min(world.geometry[a].bounding_radius, world.geometry[b].bounding_radius);
  const S tolerance_m = S(16) * real::epsilon<S>() * size;
  auto& manifolds = world.impacts.manifolds;
  S gap{};
  const auto report = [&](int iterations, SolveEnd ended) {
    const double residual = static_cast<double>(real::abs(gap) / size);
    world.model->system().solvers.add(IterativeSolver::impact_time, {iterations, residual, ended});
  };
  for (int iteration = 0; iteration < kMaxRefinements; ++iteration) {
    const Transform<S> pose_a = transform_at(world, a, predicted.t_s), pose_b = transform_at(world, b, predicted.t_s);
    manifolds.clear();
    find_contacts(world.geometry[a], pose_a, world.geometry[b], pose_b, size, manifolds);
    for (const Manifold<S>& manifold : manifolds) add_convex_solves(manifold.solve, world.model->system().solvers);
    const Vec3<S> predicted_point = pose_a.p_W + predicted.arm_a;
    const ContactPoint<S>* point = nullptr;
    S least{};
    for (const Manifold<S>& manifold : manifolds)
      for (int i = 0; i < manifold.count; ++i) {
        const Vec3<S> d = manifold.points[i].x_W - predicted_point;
        if (point != nullptr && !(dot(d, d) < least)) continue;
        least = dot(d, d);
        point = &manifold.points[i];
        predicted.normal = manifold.normal_W;
      }
    if (point == nullptr) return false;
    predicted.arm_a = point->x_W - pose_a.p_W;
    predicted.arm_b = point->x_W - pose_b.p_W;
    const LinearMotion<S> fa = linear_motion(world, a), fb = linear_motion(world, b);
    const auto speed = [&](const Vec3<S>& v_a, const Vec3<S>& v_b) { return -dot(v_b - v_a, predicted.normal); };
    const S approach = speed(fa.v + cross(fa.w, predicted.arm_a), fb.v + cross(fb.w, predicted.arm_b));
    if (!(approach > real::abs(speed(fa.dv, fb.dv)))) return false;
    gap = point->gap;
    if (real::abs(gap) <= tolerance_m) {
      report(iteration + 1, SolveEnd::converged);
      return true;
    }
    const S t_s = predicted.t_s + point->gap / approach;
    // The root lies after the substep: the velocity increment closes the remaining gap. Or before from_s: they overlap
    // there already, and the impact takes place at from_s. Unless the gap was evaluated there, that is a guess.
    const bool at_from = predicted.t_s <= from_s;
    if (t_s > world.sub_s && predicted.t_s >= world.sub_s) return true;
    predicted.t_s = real::min(real::max(t_s, from_s), world.sub_s);
    if (t_s <= from_s && iteration > 0) {
      if (!at_from) report(iteration + 1, SolveEnd::capped);
      return true;
    }
  }
  report(kMaxRefinements, SolveEnd::capped);
  return true;
}

// Applies the impulse of an impact at t_s: changes velocities and impact shifts, adds to the impulse sum, reports the
// event.
template <class S> void apply_impact(World<S>& world, int contact, const PredictedImpact<S>& predicted, S t_s) {
  const auto [a, b] = bodies_of(world, contact);
  const PairCoefficients& pair = world.coefficients(a, b);
  const ImpactLaw<S> law{S(pair.restitution), S(pair.friction), S(0), world.options.restitution};
  const LinearMotion<S> fa = linear_motion(world, a);
  const Vec3<S> x = fa.p + t_s * fa.v + predicted.arm_a;
  Impulse<S> impulse;
  Vec3<S> change;  // the impulse on b
  if (is_tied(world, a) || is_tied(world, b)) {
    impulse = collide_tied(world, a, b, law, predicted.normal, predicted.arm_a, predicted.arm_b, t_s, change);
  } else {
    ImpactBody<S> body_a = impact_body(world, a, predicted.arm_a), body_b = impact_body(world, b, predicted.arm_b);
    const Vec3<S> v_before = body_b.inverse_mass_per_kg > S(0) ? body_b.v_W : body_a.v_W;
    impulse = collide(law, predicted.normal, body_a, body_b);
    change = body_b.inverse_mass_per_kg > S(0) ? (S(1) / body_b.inverse_mass_per_kg) * (body_b.v_W - v_before)
                                               : (S(-1) / body_a.inverse_mass_per_kg) * (body_a.v_W - v_before);
    set_velocity_after_impact(world, a, body_a, t_s);
    set_velocity_after_impact(world, b, body_b, t_s);
  }
  if (!impulse.converged) world.model->system().solvers.add(IterativeSolver::slip_path, impulse.solve);
  if (world.records_impulses) {
    ImpulseSum<S>& sum = world.impulse_sums[static_cast<std::size_t>(contact)];
    const Vec3<S> along = dot(change, predicted.normal) * predicted.normal;
    sum.normal_N_s += dot(change, predicted.normal);
    sum.normal_W += along;
    sum.tangential_W += change - along;
  }
  if (world.observer != nullptr && world.observer->event) {
    Event event;
    const bool swap = a > b;
    const S sign = swap ? S(-1) : S(1);
    event.t_s = Wide(world.t_s) + Wide(t_s);
    event.kind = EventKind::impact;
    event.body_a = swap ? b : a;
    event.body_b = swap ? a : b;
    event.x_m = {Wide(x.x), Wide(x.y), Wide(x.z)};
    event.normal = {Wide(sign * predicted.normal.x), Wide(sign * predicted.normal.y), Wide(sign * predicted.normal.z)};
    event.impulse_n_N_s = Wide(impulse.normal_N_s);
    event.impulse_t_N_s = Wide(impulse.tangential_N_s);
    event.vn_before_m_per_s = Wide(impulse.vn_before_m_per_s);
    event.vn_after_m_per_s = Wide(impulse.vn_after_m_per_s);
    world.observer->event(event);
  }
}

// The bodies that move with a tied one.
template <class S> const std::vector<int>& mechanism_with(const World<S>& world, int body) {
  const TiedBodies<S>& tied = *world.tied;
  return tied.mechanisms[static_cast<std::size_t>(tied.mechanism_of[static_cast<std::size_t>(body)])].bodies;
}

// Sets ImpactQueue::with_restitution, first and of_body.
template <class S> void list_contacts_by_body(World<S>& world, int contacts) {
  ImpactQueue<S>& impacts = world.impacts;
  impacts.first.assign(static_cast<std::size_t>(world.bodies.count) + 2, 0);
  impacts.with_restitution.clear();
  const auto each = [&](const auto& visit) {
    for (const int contact : impacts.with_restitution) {
      const auto [a, b] = bodies_of(world, contact);
      if (world.bodies.moves[a]) visit(a, contact);
      if (world.bodies.moves[b]) visit(b, contact);
    }
  };
  for (int contact = 0; contact < contacts; ++contact) {
    if (!is_contact(world, contact) || !(restitution_of(world, contact) > S(0))) continue;
    impacts.with_restitution.push_back(contact);
  }
  each([&](int body, int) { ++impacts.first[body + 2]; });
  for (std::size_t i = 2; i < impacts.first.size(); ++i) impacts.first[i] += impacts.first[i - 1];
  impacts.of_body.resize(static_cast<std::size_t>(impacts.first.back()));
  each([&](int body, int contact) { impacts.of_body[static_cast<std::size_t>(impacts.first[body + 1]++)] = contact; });
}

// Speed at which the gap of a predicted impact closes.
template <class S> S approach_speed_m_per_s(const World<S>& world, int contact, const PredictedImpact<S>& predicted) {
  const auto [a, b] = bodies_of(world, contact);
  const LinearMotion<S> fa = linear_motion(world, a), fb = linear_motion(world, b);
  return -dot((fb.v + cross(fb.w, predicted.arm_b)) - (fa.v + cross(fa.w, predicted.arm_a)), predicted.normal);
}

// Impacts count as simultaneous if their times differ by less than this: round-off of the positions over the speed
// at which the gap closes, and round-off of the time.
template <class S> S simultaneity_tolerance_s(const World<S>& world, int contact, S approach) {
  const auto [a, b] = bodies_of(world, contact);
  const auto size = [&](int body) {
    const S own = world.geometry[body].kind == ShapeKind::plane ? real::abs(world.geometry[body].offset)
                                                                : world.geometry[body].bounding_radius;
    return norm(load3(world.bodies.pose[body].at)) + own;
  };
  return S(16) * real::epsilon<S>() * (world.sub_s + (size(a) + size(b)) / approach);
}

// Of the impacts that are simultaneous with `next`, sets `next` and `predicted` to the one that approaches fastest,
// ties by the order of the bodies; the others go back into the queue. For scenes whose simultaneous impacts are
// sequential.
template <class S, class Later>
void select_fastest_approach(World<S>& world, S now_s, const Later& later, PredictedTime<S>& next,
                             PredictedImpact<S>& predicted) {
  auto& queue = world.impacts.queue;
  auto& simultaneous = world.impacts.simultaneous;
  simultaneous.clear();
  S fastest = approach_speed_m_per_s(world, next.contact, predicted);
  const S until_s = predicted.t_s + simultaneity_tolerance_s(world, next.contact, fastest);
  const auto order = [&](int contact) {
    const auto [a, b] = bodies_of(world, contact);
    return std::pair(std::min(a, b), std::max(a, b));
  };
  while (!queue.empty() && queue.front().t_s <= until_s) {
    std::pop_heap(queue.begin(), queue.end(), later);
    const PredictedTime<S> other = queue.back();
    queue.pop_back();
    const PredictedImpact<S> candidate = predict_impact(world, other.contact, now_s);
    if (!candidate.occurs || other.contact == next.contact) continue;
    const S approach = approach_speed_m_per_s(world, other.contact, candidate),
            tolerance = S(64) * real::epsilon<S>() * fastest;
    const bool first_of_tie = approach >= fastest - tolerance && order(other.contact) < order(next.contact);
    const bool preferred = candidate.t_s <= until_s && (approach > fastest + tolerance || first_of_tie);
    simultaneous.push_back(preferred ? PredictedTime<S>{predicted.t_s, next.contact}
                                     : PredictedTime<S>{candidate.t_s, other.contact});
    if (!preferred) continue;
    next = other;
    predicted = candidate;
    fastest = approach;
  }
  for (const PredictedTime<S>& other : simultaneous) {
    queue.push_back(other);
    std::push_heap(queue.begin(), queue.end(), later);
  }
}

// What an impact takes of the limit: 1 where it leaves at most half of the approach speed, 0 where it leaves all.
template <class S> S loss_by(S restitution) { return real::min(S(1), S(2) * (S(1) - restitution)); }

// The limits of one substep, and what has been resolved in it.
template <class S> struct ImpactCount {
  S loss_left{}, last_s{}, fastest{};  // last_s: of the last impact at a contact
  std::size_t resolved = 0, at_an_instant = 0, most_at_an_instant = 0;
  bool missed_a_pair = false;  // an impact sent a body where candidate pairs are not known before the next step
  bool left_a_stop = false;    // more impacts at stops than the limit

  explicit ImpactCount(std::size_t contacts)
      : loss_left(S(kMaxLossPerContact) * S(contacts)),
        most_at_an_instant(std::max(kMaxImpactsAtAnInstant, kMaxImpactsAtAnInstantPerContact * contacts)) {}
  bool may_go_on() const { return loss_left > S(0) && at_an_instant <= most_at_an_instant; }
  void add(S t_s, S approach, S restitution) {
    ++resolved;
    at_an_instant = t_s > last_s ? 0 : at_an_instant + 1;
    last_s = t_s;
    fastest = real::max(fastest, approach);
    loss_left -= loss_by(restitution);
  }
};

// Adds the substep's queue to the tallies. Its residual is the fastest approach that was left to the velocity solver,
// over the fastest that was resolved.
template <class S> void report_impact_queue(World<S>& world, const ImpactCount<S>& count, S now_s) {
  const bool incomplete = count.missed_a_pair || count.left_a_stop;
  if (count.resolved == 0 && !incomplete) return;
  S left{};
  for (const PredictedTime<S>& next : world.impacts.queue) {
    const PredictedImpact<S> predicted = predict_impact(world, next.contact, now_s);
    if (predicted.occurs) left = real::max(left, approach_speed_m_per_s(world, next.contact, predicted));
  }
  const S residual = left > S(0) ? left / count.fastest : S(0);
  world.model->system().solvers.add(IterativeSolver::impact_queue,
                                    {static_cast<std::int64_t>(count.resolved), static_cast<double>(residual),
                                     left > S(0) || incomplete ? SolveEnd::capped : SolveEnd::converged});
}

}  // namespace

template <class S> void list_contacts_with_restitution(World<S>& world) {
  if (!world.has_restitution) return;
  list_contacts_by_body(world, point_count(world));
}

template <class S> void resolve_impacts(World<S>& world) {
  const bool has_stops = world.tied != nullptr && world.tied->has_stop_restitution;
  if (!world.has_restitution && !has_stops) return;
  ImpactQueue<S>& impacts = world.impacts;
  auto& queue = impacts.queue;
  queue.clear();
  const auto later = [](const PredictedTime<S>& x, const PredictedTime<S>& y) {
    return x.t_s != y.t_s ? x.t_s > y.t_s : x.contact > y.contact;
  };
  S now_s{};
  const bool sequential = world.scene->simultaneous_impacts == SimultaneousImpacts::sequential;
  const auto enqueue = [&](int contact) {
    const PredictedImpact<S> predicted = predict_impact(world, contact, now_s);
    if (!predicted.occurs) return;
    queue.push_back({predicted.t_s, contact});
    std::push_heap(queue.begin(), queue.end(), later);
  };
  const auto enqueue_contacts_of = [&](int body) {
    if (!world.has_restitution || !world.bodies.moves[body]) return;
    for (int i = impacts.first[body]; i < impacts.first[body + 1]; ++i)
      enqueue(impacts.of_body[static_cast<std::size_t>(i)]);
  };
  ImpactCount<S> count(impacts.with_restitution.size());
  const auto enqueue_contacts_after = [&](int body) {
    if (!world.bodies.moves[body]) return;
    count.missed_a_pair = count.missed_a_pair || may_miss_a_pair(world, body, world.step_end_s - world.t_s);
    enqueue_contacts_of(body);
  };
  // An impact at a stop comes first where it is earlier, and changes what the contacts of its mechanism meet.
  std::size_t stop_impacts_left = has_stops ? kMaxImpactsPerStop * world.tied->stops.size() : 0;
  const auto resolve_stop = [&](S until_s) {
    if (stop_impacts_left == 0) {
      count.left_a_stop = count.left_a_stop || (has_stops && reaches_stop(world, now_s, until_s));
      return false;
    }
    const Mechanism<S>* mechanism = resolve_stop_impact(world, now_s, until_s);
    if (mechanism == nullptr) return false;
    --stop_impacts_left;
    for (const int body : mechanism->bodies) enqueue_contacts_after(body);
    return true;
  };
  if (world.has_restitution)
    for (const int contact : impacts.with_restitution) enqueue(contact);
  for (;;) {
    if (queue.empty()) {
      if (resolve_stop(world.sub_s)) continue;
      break;
    }
    if (!count.may_go_on()) break;
    std::pop_heap(queue.begin(), queue.end(), later);
    PredictedTime<S> next = queue.back();
    queue.pop_back();
    PredictedImpact<S> predicted = predict_impact(world, next.contact, now_s);
    if (!predicted.occurs) continue;                            // an impact since then prevents it
    if (!queue.empty() && predicted.t_s > queue.front().t_s) {  // it comes later now
      queue.push_back({predicted.t_s, next.contact});
      std::push_heap(queue.begin(), queue.end(), later);
      continue;
    }
    if (resolve_stop(predicted.t_s)) {  // it may come at another time now
      queue.push_back({predicted.t_s, next.contact});
      std::push_heap(queue.begin(), queue.end(), later);
      continue;
    }
    if (sequential) select_fastest_approach(world, now_s, later, next, predicted);
    if (!refine_on_surfaces(world, next.contact, now_s, predicted)) continue;
    now_s = predicted.t_s;
    count.add(now_s, approach_speed_m_per_s(world, next.contact, predicted), restitution_of(world, next.contact));
    apply_impact(world, next.contact, predicted, now_s);
    const auto [a, b] = bodies_of(world, next.contact);
    for (const int body : {a, b}) {
      if (!is_tied(world, body)) enqueue_contacts_after(body);
      else
        for (const int other : mechanism_with(world, body)) enqueue_contacts_after(other);
    }
  }
  report_impact_queue(world, count, now_s);
  if (count.at_an_instant > count.most_at_an_instant && !world.end.impacts_stalled) {
    world.end.impacts_stalled = true;
    world.end.stall_time_s = world.t_s + now_s;
  }
}

#define ATWOOD_IMPACTS(S)                                     \
  template void list_contacts_with_restitution<S>(World<S>&); \
  template void resolve_impacts<S>(World<S>&);
ATWOOD_IMPACTS(float)
ATWOOD_IMPACTS(double)
#undef ATWOOD_IMPACTS

}  // namespace atwood::stepping
