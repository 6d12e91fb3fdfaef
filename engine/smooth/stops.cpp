#include "smooth/stops.hpp"

#include <algorithm>

#include "joints/constraints.hpp"
#include "math/bracketed_root.hpp"

namespace atwood {
namespace {

constexpr int kMaxEventsAtAnInstant = 20000;

template <class S> S sign(bool lower) { return lower ? S(1) : S(-1); }

}  // namespace

template <class S> Stops<S>::Stops(Simulation<S>& simulation) : simulation_(simulation) {
  RigidModel<S>& model = *simulation.model;
  if (model.constraints() == nullptr) return;
  const auto& stops = model.constraints()->stops();
  for (int i = 0; i < static_cast<int>(stops.size()); ++i) {
    const S scale = real::max(real::abs(stops[i].lower), real::abs(stops[i].upper));
    const S round_off = S(16) * real::epsilon<S>() * real::max(scale, stops[i].upper - stops[i].lower);
    sides_.push_back({i, Side::lower, stops[i].lower, round_off});
    sides_.push_back({i, Side::upper, stops[i].upper, round_off});
  }
  rates_.resize(model.state_size());
  du_.resize(model.tree()->rate_count());
}

template <class S> S Stops<S>::gap(const Limit& limit, const S* y) const {
  const S q = y[simulation_.model->constraints()->stops()[limit.stop].q_at];
  return limit.side == Side::lower ? q - limit.at : limit.at - q;
}

template <class S> S Stops<S>::rate(const Limit& limit, const S* y) const {
  return sign<S>(limit.side == Side::lower) * y[simulation_.model->constraints()->stops()[limit.stop].u_at];
}

template <class S> bool Stops<S>::probe(S t_s, S h_s, S fraction) {
  moved_to_ = fraction;
  return simulation_.stepper->step(t_s, fraction * h_s, simulation_.y.data(), simulation_.y_new.data());
}

// Of the constraint that holds a resting coordinate, away from the stop.
template <class S> S Stops<S>::holding_force(const Limit& limit, S t_s, const S* y) {
  RigidModel<S>& model = *simulation_.model;
  model.system().rate(t_s, y, rates_.data());
  return sign<S>(limit.side == Side::lower) *
         model.constraints()->locked_force(model.constraints()->stops()[limit.stop].joint);
}

template <class S> void Stops<S>::note(int iterations, S width, bool converged) {
  simulation_.model->system().solvers.add(
      IterativeSolver::event_location,
      {iterations, static_cast<double>(width), converged ? SolveEnd::converged : SolveEnd::capped});
}

// ---- where the first event is ---------------------------------------------------------------------------------------
// `fraction` becomes the first one in (0, until] at which the gap is zero; unchanged if there is none.
template <class S> bool Stops<S>::first_passage(S t_s, S h_s, Limit& limit, S until, S& fraction) {
  constexpr int max_evaluations = 200, max_halvings = 80;
  const std::vector<S>& y_new = simulation_.y_new;
  S high = until, gap_high = limit.gap_end;
  if (!(gap_high < -limit.round_off)) {  // within the limits at the end: has it dipped below in between?
    if (!(limit.rate_start < S(0) && limit.rate_end > S(0))) return true;
    S low = S(0);
    int halvings = 0;
    for (; halvings < max_halvings; ++halvings) {
      const S middle = low + (high - low) / S(2);
      if (!probe(t_s, h_s, middle)) return false;
      gap_high = gap(limit, y_new.data());
      if (gap_high < -limit.round_off) {
        high = middle;
        break;
      }
      const S slope = rate(limit, y_new.data());
      // Convex between two slopes of opposite signs: above both tangents.
      if (gap_high > S(0) && gap_high - real::abs(slope) * (high - low) * h_s > S(0)) return true;
      (slope < S(0) ? low : high) = middle;
      if (high - low <= real::epsilon<S>()) break;
    }
    const bool dips = gap_high < -limit.round_off;
    note(halvings, high - low, dips || high - low <= real::epsilon<S>());
    if (!dips) return true;
  }
  S low = S(0), gap_low = limit.gap_start;
  if (!(gap_low > S(0))) {  // it starts at its limit: from where it has left it
    if (limit.rate_start <= S(0) && limit.gap_start <= limit.round_off && limit.rate_start < S(0)) {
      fraction = S(0);
      return true;
    }
    const S least = high * S(0x1p-50);
    for (low = high / S(2); low > least; low = low / S(2)) {
      if (!probe(t_s, h_s, low)) return false;
      gap_low = gap(limit, y_new.data());
      if (gap_low > S(0)) break;
      high = low;
      gap_high = gap_low;
    }
    if (!(gap_low > S(0))) {
      fraction = S(0);
      return true;
    }
  }
  bool solved = true;
  const auto below = [&](S x) {
    solved = solved && probe(t_s, h_s, x);
    return -gap(limit, y_new.data());
  };
  const BracketedRoot<S> root =
      false_position(below, low, -gap_low, high, -gap_high, real::epsilon<S>(), max_evaluations);
  note(root.evaluations, root.high - root.low, root.converged);
  fraction = root.high;
  return solved;
}

template <class S> bool Stops<S>::first_release(S t_s, S h_s, Limit& limit, S until, S& fraction) {
  constexpr int max_evaluations = 200;
  const S force_end = holding_force(limit, t_s + until * h_s, simulation_.y_new.data());
  if (!(force_end < S(0))) return true;
  const S force_start = holding_force(limit, t_s, simulation_.y.data());
  if (!(force_start > S(0))) {
    fraction = S(0);
    return true;
  }
  bool solved = true;
  const auto pull = [&](S x) {
    solved = solved && probe(t_s, h_s, x);
    return -holding_force(limit, t_s + x * h_s, simulation_.y_new.data());
  };
  const BracketedRoot<S> root =
      false_position(pull, S(0), -force_start, until, -force_end, real::epsilon<S>(), max_evaluations);
  note(root.evaluations, root.high - root.low, root.converged);
  fraction = root.high;
  return solved;
}

template <class S> bool Stops<S>::locate(S t_s, S h_s, S& fraction) {
  fraction = moved_to_ = S(1);
  bool any = false;
  for (Limit& limit : sides_) {
    limit.reached = false;
    limit.gap_start = gap(limit, simulation_.y.data());
    limit.rate_start = rate(limit, simulation_.y.data());
    // y_new at the end of what is searched: the step, or the first event so far
    if (moved_to_ != fraction && fraction > S(0) && !probe(t_s, h_s, fraction)) return false;
    if (fraction == S(0)) simulation_.y_new = simulation_.y;
    limit.gap_end = gap(limit, simulation_.y_new.data());
    limit.rate_end = rate(limit, simulation_.y_new.data());
    S at = S(2);
    if (!(limit.resting ? first_release(t_s, h_s, limit, fraction, at) : first_passage(t_s, h_s, limit, fraction, at)))
      return false;
    if (at > fraction) continue;
    if (at < fraction)
      for (Limit& other : sides_) other.reached = false;
    any = true;
    fraction = at;
    limit.reached = true;
  }
  at_event_ = any;
  if (fraction > S(0)) return moved_to_ == fraction || probe(t_s, h_s, fraction);
  simulation_.y_new = simulation_.y;
  return true;
}

// ---- what happens there ---------------------------------------------------------------------------------------------
template <class S> void Stops<S>::report(EventKind kind, const Limit& limit, S t_s, S impulse, S before, S after) {
  if (observer_ == nullptr || !observer_->event) return;
  Constraints<S>& constraints = *simulation_.model->constraints();
  const auto& stop = constraints.stops()[limit.stop];
  const Tree<S>& tree = *simulation_.model->tree();
  const LinkMotion<S>& m = tree.motion(stop.link);
  const Vec3<S> axis = sign<S>(limit.side == Side::lower) * tree.column(stop.rate).s;
  Event event;
  event.t_s = t_s;
  event.kind = kind;
  event.body_a = stop.parent;
  event.body_b = stop.child;
  event.x_m = {m.A.x, m.A.y, m.A.z};
  event.normal = {axis.x, axis.y, axis.z};
  event.impulse_n_N_s = impulse;
  event.vn_before_m_per_s = before;
  event.vn_after_m_per_s = after;
  observer_->event(event);
}

// The impulses of all coordinates that are at their limits and move outwards.
template <class S> bool Stops<S>::resolve_impacts(S t_s) {
  RigidModel<S>& model = *simulation_.model;
  Constraints<S>& constraints = *model.constraints();
  std::vector<S>& y = simulation_.y;
  for (int round = 0; round < 100; ++round) {
    std::vector<int> joints, at;
    std::vector<S> change, impulse, before;
    for (int i = 0; i < static_cast<int>(sides_.size()); ++i) {
      const Limit& limit = sides_[i];
      const auto& stop = constraints.stops()[limit.stop];
      const S into = rate(limit, y.data());
      if (limit.resting || !(gap(limit, y.data()) <= limit.round_off) || !(into < S(0))) continue;
      joints.push_back(stop.joint);
      at.push_back(i);
      before.push_back(into);
      change.push_back(-(S(1) + stop.restitution) * into * sign<S>(limit.side == Side::lower));
      y[stop.q_at] = limit.at;
    }
    if (joints.empty()) return true;
    impulse.resize(joints.size());
    constraints.impact_at_limits(y.data(), joints, change, du_.data(), impulse.data());
    for (Limit& limit : sides_) {  // a stop pushes: one that would have to pull lets go
      if (!limit.resting) continue;
      const auto& stop = constraints.stops()[limit.stop];
      if (constraints.locked_force(stop.joint) * sign<S>(limit.side == Side::lower) < S(0)) {
        limit.resting = false;
        constraints.lock(stop.joint, false);
        report(EventKind::separate, limit, t_s, S(0), S(0), S(0));
        constraints.impact_at_limits(y.data(), joints, change, du_.data(), impulse.data());
      }
    }
    for (std::size_t k = 0; k < du_.size(); ++k)
      if (du_[k] != S(0)) y[model.tree()->state_of_rate(static_cast<int>(k))] += du_[k];
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Limit& limit = sides_[at[i]];
      const auto& stop = constraints.stops()[limit.stop];
      y[stop.u_at] = -stop.restitution * before[i] * sign<S>(limit.side == Side::lower);
      report(EventKind::impact, limit, t_s, real::abs(impulse[i]), before[i], rate(limit, y.data()));
    }
    ++model.system().epoch;
  }
  fault_ = "impacts at joint limits follow each other without end";
  return false;
}

// Coordinates at their limits whose bounces have come to an end, or that are pressed against them from rest, are held.
template <class S> void Stops<S>::settle(S t_s) {
  RigidModel<S>& model = *simulation_.model;
  Constraints<S>& constraints = *model.constraints();
  std::vector<S>& y = simulation_.y;
  for (Limit& limit : sides_) {
    if (limit.resting || !(gap(limit, y.data()) <= limit.round_off)) continue;
    const auto& stop = constraints.stops()[limit.stop];
    const S away = rate(limit, y.data());
    if (away < S(0)) continue;
    model.system().rate(t_s, y.data(), rates_.data());
    const S pressing = -sign<S>(limit.side == Side::lower) * rates_[stop.u_at];
    // A force that begins at zero presses in the step that locate() has tried.
    const bool pressed_later = limit.reached && away == S(0) && pressing == S(0) && limit.gap_end < -limit.round_off;
    if (!pressed_later && (!(pressing > S(0)) || away * away > S(4) * pressing * limit.round_off)) continue;
    if (away > S(0) && stop.restitution >= S(1)) continue;
    const S rest_s = away > S(0) ? t_s + S(2) * away / (pressing * (S(1) - stop.restitution)) : t_s;
    if (away > S(0)) {
      S impulse{};
      constraints.impact_at_limits(y.data(), {stop.joint}, {-y[stop.u_at]}, du_.data(), &impulse);
      for (std::size_t k = 0; k < du_.size(); ++k)
        if (du_[k] != S(0)) y[model.tree()->state_of_rate(static_cast<int>(k))] += du_[k];
    }
    y[stop.q_at] = limit.at;
    y[stop.u_at] = S(0);
    limit.resting = true;
    constraints.lock(stop.joint, true, limit.at);
    ++model.system().epoch;
    report(EventKind::rest, limit, rest_s, S(0), -away, S(0));
  }
}

template <class S> bool Stops<S>::resolve(S t_s) {
  Constraints<S>& constraints = *simulation_.model->constraints();
  events_at_instant_ = t_s > event_s_ + S(64) * real::epsilon<S>() * real::abs(t_s) ? 0 : events_at_instant_ + 1;
  event_s_ = real::max(event_s_, t_s);
  if (events_at_instant_ > kMaxEventsAtAnInstant) {
    fault_ = "20000 events of stops followed each other without the time advancing";
    return false;
  }
  for (Limit& limit : sides_) {
    if (!limit.reached || !limit.resting) continue;
    limit.resting = false;
    constraints.lock(constraints.stops()[limit.stop].joint, false);
    ++simulation_.model->system().epoch;
    report(EventKind::separate, limit, t_s, S(0), S(0), S(0));
    limit.reached = false;
    if (!resolve_impacts(t_s)) return false;
    return true;  // it is not pressed against its stop any more, but for round-off
  }
  if (!resolve_impacts(t_s)) return false;
  settle(t_s);
  return true;
}

template <class S> bool Stops<S>::start(const Observer* observer) {
  observer_ = observer;
  fault_.clear();
  event_s_ = S(0);
  events_at_instant_ = 0;
  for (Limit& limit : sides_) {
    const auto& stop = simulation_.model->constraints()->stops()[limit.stop];
    limit.resting = limit.reached = false;
    simulation_.model->constraints()->lock(stop.joint, false);
    if (gap(limit, simulation_.y.data()) < -limit.round_off) {
      fault_ = "joint `" + stop.name + "` starts beyond its limits";
      return false;
    }
  }
  settle(S(0));
  return true;
}

template <class S> bool Stops<S>::resolve_start() {
  if (!resolve_impacts(S(0))) return false;
  settle(S(0));
  return true;
}

template class Stops<float>;
template class Stops<double>;
template class Stops<long double>;
template class Stops<Quad>;

}  // namespace atwood
