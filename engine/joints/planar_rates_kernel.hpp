// The passes over a tree in planes (joints/planar_rates.hpp), of one state or of eight at once.
#pragma once

#include "joints/planar_rates.hpp"
#include "math/sin_cos.hpp"

namespace atwood {

template <class S>
template <class States>
ATWOOD_INLINE auto PlanarRates<S>::coordinate(const Constants& link, const States& y, DrivenJoints driven) ->
    typename States::Value {
  const bool by_time = link.driven && driven == DrivenJoints::from_time;
  return by_time ? link.driven_start + y.time() * link.driven_rate : y.at(link.at_q);
}

// Outward pass: attitudes and angular velocities, and the rates of the coordinates. Turning a vector by z multiplies
// complex numbers. `turned`: each hinge's own turn stands in its link's z already.
template <class S>
template <class States, class V>
ATWOOD_INLINE void PlanarRates<S>::outward_pass(const States& y, bool turned, State<V>* state,
                                                DrivenJoints driven) const {
  const V zero = in_all_lanes<V>(S(0)), one = in_all_lanes<V>(S(1));
  Pair<V> z{one, zero};  // of the link before, which mostly is the parent
  V w = zero;
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
    if (link.parent < 0) {
      z = {one, zero};
      w = zero;
    } else if (link.parent != i - 1) {
      z = state[link.parent].z;
      w = state[link.parent].w;
    }
    if (link.turns || link.slides) {
      const V u =
          link.driven && driven == DrivenJoints::from_time ? in_all_lanes<V>(link.driven_rate) : y.at(link.at_u);
      y.set(link.at_q, u);
      if (link.turns) {
        Pair<V> turn = m.z;
        if (!turned) {
          real::same_sin_cos(coordinate(link, y, driven), turn.y, turn.x);
          turn.y = link.sign * turn.y;
        }
        z = {z.x * turn.x - z.y * turn.y, z.x * turn.y + z.y * turn.x};
        w = w + link.sign * u;
      } else {
        m.offset = coordinate(link, y, driven);
        m.speed = u;
      }
    }
    m.z = z;
    m.w = w;
  }
}

// What a link needs of its parent's attitude and its own: its place, its inertia, and the bias of its motion at
// constant rates (Featherstone 2008, table 7.1). What a turn at unit rate makes of v is (-v.y, v.x).
template <class S> template <class V> ATWOOD_INLINE void PlanarRates<S>::start_link(int i, State<V>* state) const {
  const V zero = in_all_lanes<V>(S(0));
  const Constants& link = links_[i];
  State<V>& m = state[i];
  Pair<V> z0{in_all_lanes<V>(S(1)), zero};
  V w0 = zero;
  if (link.parent >= 0) {
    z0 = state[link.parent].z;
    w0 = state[link.parent].w;
  }
  const auto rotated = [](const Pair<V>& z, const Vec2& v) ATWOOD_INLINED {
    return Pair<V>{z.x * v.x - z.y * v.y, z.x * v.y + z.y * v.x};
  };
  m.d = rotated(z0, link.from_parent);
  m.c = {zero, zero};
  if (link.slides) {
    m.s = rotated(z0, link.axis);
    m.d = {m.d.x + m.offset * m.s.x, m.d.y + m.offset * m.s.y};
    const V coriolis = S(2) * (w0 * m.speed);  // Coriolis: 2 w x s u
    m.c = {-coriolis * m.s.y, coriolis * m.s.x};
  }
  const V w0_square = w0 * w0;
  m.c = {m.c.x - w0_square * m.d.x, m.c.y - w0_square * m.d.y};
  const Pair<V> r = rotated(m.z, link.to_centre);
  m.J = in_all_lanes<V>(link.J);
  m.h = {-link.mass * r.y, link.mass * r.x};
  m.Mxx = m.Myy = in_all_lanes<V>(link.mass);
  m.Mxy = m.n = zero;
  const V centripetal = -link.mass * (m.w * m.w);
  m.f = {centripetal * r.x, centripetal * r.y};
}

template <class S> template <class V> ATWOOD_INLINE void PlanarRates<S>::start_links(State<V>* state) const {
  for (std::size_t i = 0; i < links_.size(); ++i) start_link(static_cast<int>(i), state);
}

// Inward pass: articulated inertias and bias wrenches, rate by rate. Links from `started` on have been started; the
// others are as late as their children allow, for this pass waits for each link's result and leaves room beside it.
template <class S>
template <class Applied, class V>
ATWOOD_INLINE void PlanarRates<S>::inward_pass(const Applied& applied, int started, State<V>* state) const {
  for (int i = static_cast<int>(links_.size()) - 1; i >= 0; --i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
    while (started > (link.parent >= 0 ? link.parent : i)) start_link(--started, state);
    const auto add_to_parent = [&](const V& Mxx, const V& Mxy, const V& Myy, const Pair<V>& f) ATWOOD_INLINED {
      State<V>& to = state[link.parent];
      const Pair<V> g{Mxy * m.d.x - Mxx * m.d.y, Myy * m.d.x - Mxy * m.d.y};  // M (-d.y, d.x)
      to.J = to.J + (m.d.x * g.y - m.d.y * g.x);
      to.h = {to.h.x + g.x, to.h.y + g.y};
      to.Mxx = to.Mxx + Mxx;
      to.Mxy = to.Mxy + Mxy;
      to.Myy = to.Myy + Myy;
      to.n = to.n + (m.d.x * f.y - m.d.y * f.x);
      to.f = {to.f.x + f.x, to.f.y + f.y};
    };
    if (link.turns && !link.driven) {  // neither J nor h is left
      const V torque = link.sign * applied[link.rate];
      m.inverse_D = S(1) / m.J;
      m.force = torque - m.n;
      if (link.parent < 0) continue;
      const V u_dot = m.force * m.inverse_D;
      const Pair<V> k{m.inverse_D * m.h.x, m.inverse_D * m.h.y};
      const V Mxx = m.Mxx - k.x * m.h.x, Mxy = m.Mxy - k.x * m.h.y, Myy = m.Myy - k.y * m.h.y;
      state[link.parent].n = state[link.parent].n + torque;
      add_to_parent(
          Mxx, Mxy, Myy,
          {m.f.x + u_dot * m.h.x + Mxx * m.c.x + Mxy * m.c.y, m.f.y + u_dot * m.h.y + Mxy * m.c.x + Myy * m.c.y});
      continue;
    }
    V J = m.J, n = m.n, Mxx = m.Mxx, Mxy = m.Mxy, Myy = m.Myy;
    Pair<V> h = m.h, f = m.f;
    if (link.slides && !link.driven) {
      m.Un = h.x * m.s.x + h.y * m.s.y;
      m.Uf = {Mxx * m.s.x + Mxy * m.s.y, Mxy * m.s.x + Myy * m.s.y};
      m.inverse_D = S(1) / (m.s.x * m.Uf.x + m.s.y * m.Uf.y);
      m.force = applied[link.rate] - (m.s.x * f.x + m.s.y * f.y);
      const V u_dot = m.force * m.inverse_D, k = m.inverse_D * m.Un;
      const Pair<V> l{m.inverse_D * m.Uf.x, m.inverse_D * m.Uf.y};
      J = J - k * m.Un;
      h = {h.x - k * m.Uf.x, h.y - k * m.Uf.y};
      Mxx = Mxx - l.x * m.Uf.x;
      Mxy = Mxy - l.x * m.Uf.y;
      Myy = Myy - l.y * m.Uf.y;
      n = n + u_dot * m.Un;
      f = {f.x + u_dot * m.Uf.x, f.y + u_dot * m.Uf.y};
    }
    if (link.parent < 0) continue;
    State<V>& to = state[link.parent];
    to.J = to.J + (J + S(2) * (m.d.x * h.y - m.d.y * h.x));
    to.h = {to.h.x + h.x, to.h.y + h.y};
    to.n = to.n + (n + h.x * m.c.x + h.y * m.c.y);
    add_to_parent(Mxx, Mxy, Myy, {f.x + Mxx * m.c.x + Mxy * m.c.y, f.y + Mxy * m.c.x + Myy * m.c.y});
  }
}

// Outward pass: accelerations relative to free fall, so that gravity is an acceleration of the roots. A hinge gives
// alpha itself.
template <class S>
template <class States, class V>
ATWOOD_INLINE void PlanarRates<S>::acceleration_pass(const States& y, const Vec3<S>& gravity_W, State<V>* state) const {
  const V zero = in_all_lanes<V>(S(0));
  V alpha = zero;  // of the link before, which mostly is the parent
  Pair<V> a{zero, zero};
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
    if (link.parent >= 0) {
      if (link.parent != i - 1) {
        alpha = state[link.parent].alpha;
        a = state[link.parent].a;
      }
      a = {a.x - alpha * m.d.y + m.c.x, a.y + alpha * m.d.x + m.c.y};
    } else {
      alpha = zero;
      a = {in_all_lanes<V>(-dot(gravity_W, planes_[link.plane].e1)),
           in_all_lanes<V>(-dot(gravity_W, planes_[link.plane].e2))};
    }
    if (link.driven) {
      y.set(link.at_u, zero);
    } else if (link.turns) {
      const V alpha0 = alpha;
      alpha = (m.force - (m.h.x * a.x + m.h.y * a.y)) * m.inverse_D;
      y.set(link.at_u, link.sign * (alpha - alpha0));
    } else if (link.slides) {
      const V u_dot = (m.force - (m.Un * alpha + (m.Uf.x * a.x + m.Uf.y * a.y))) * m.inverse_D;
      a = {a.x + u_dot * m.s.x, a.y + u_dot * m.s.y};
      y.set(link.at_u, u_dot);
    }
    m.alpha = alpha;
    m.a = a;
  }
}

}  // namespace atwood
