// The three passes over a tree in planes (joints/planar_rates.hpp), of one state or of eight at once.
#pragma once

#include "joints/planar_rates.hpp"
#include "math/sin_cos.hpp"

namespace atwood {

// Outward pass: positions, velocities, and the bias wrench at constant rates (Featherstone 2008, table 7.1). Turning a
// vector by z multiplies complex numbers; the vector that a turn at unit rate gives to v is (-v.y, v.x).
template <class S>
template <class States, class V>
ATWOOD_INLINE void PlanarRates<S>::outward_pass(const States& y, State<V>* state, DrivenJoints driven) const {
  const V zero = in_all_lanes<V>(S(0)), one = in_all_lanes<V>(S(1));
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
    Pair<V> z0{one, zero};
    V w0 = zero;
    if (link.parent >= 0) {
      z0 = state[link.parent].z;
      w0 = state[link.parent].w;
    }
    const auto rotated = [](const Pair<V>& z, const Vec2& v) ATWOOD_INLINED {
      return Pair<V>{z.x * v.x - z.y * v.y, z.x * v.y + z.y * v.x};
    };
    m.d = rotated(z0, link.from_parent);
    m.z = z0;
    m.w = w0;
    m.c = {zero, zero};
    if (link.turns || link.slides) {
      V q, u;
      if (link.driven && driven == DrivenJoints::from_time) {
        q = link.driven_start + y.time() * link.driven_rate;
        u = in_all_lanes<V>(link.driven_rate);
      } else {
        q = y.at(link.at_q);
        u = y.at(link.at_u);
      }
      y.set(link.at_q, u);
      if (link.turns) {
        V sine, cosine;
        real::same_sin_cos(q, sine, cosine);
        sine = link.sign * sine;
        m.z = {z0.x * cosine - z0.y * sine, z0.x * sine + z0.y * cosine};
        m.w = w0 + link.sign * u;
      } else {
        m.s = rotated(z0, link.axis);
        m.d = {m.d.x + q * m.s.x, m.d.y + q * m.s.y};
        const V coriolis = S(2) * (w0 * u);  // Coriolis: 2 w x s u
        m.c = {-coriolis * m.s.y, coriolis * m.s.x};
      }
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
}

// Inward pass: articulated inertias and bias wrenches, rate by rate.
template <class S>
template <class Applied, class V>
ATWOOD_INLINE void PlanarRates<S>::inward_pass(const Applied& applied, State<V>* state) const {
  for (int i = static_cast<int>(links_.size()) - 1; i >= 0; --i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
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
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Constants& link = links_[i];
    State<V>& m = state[i];
    V alpha0 = zero;
    Pair<V> a;
    if (link.parent >= 0) {
      const State<V>& parent = state[link.parent];
      alpha0 = parent.alpha;
      a = {parent.a.x - alpha0 * m.d.y + m.c.x, parent.a.y + alpha0 * m.d.x + m.c.y};
    } else {
      a = {in_all_lanes<V>(-dot(gravity_W, planes_[link.plane].e1)),
           in_all_lanes<V>(-dot(gravity_W, planes_[link.plane].e2))};
    }
    m.alpha = alpha0;
    m.a = a;
    if (link.driven) {
      y.set(link.at_u, zero);
    } else if (link.turns) {
      m.alpha = (m.force - (m.h.x * a.x + m.h.y * a.y)) * m.inverse_D;
      y.set(link.at_u, link.sign * (m.alpha - alpha0));
    } else if (link.slides) {
      const V u_dot = (m.force - (m.Un * alpha0 + (m.Uf.x * a.x + m.Uf.y * a.y))) * m.inverse_D;
      m.a = {a.x + u_dot * m.s.x, a.y + u_dot * m.s.y};
      y.set(link.at_u, u_dot);
    }
  }
}

}  // namespace atwood
