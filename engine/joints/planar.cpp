#include "joints/planar.hpp"

namespace atwood {
namespace {

template <class S> Vec3<S> first_hinge_axis(const Tree<S>& tree, int root, const Quat<S>& q_root) {
  const auto& links = tree.links();
  std::vector<Quat<S>> q(links.size());
  for (int i = root; i < static_cast<int>(links.size()); ++i) {
    if (links[i].parent < 0 && i > root) break;
    q[i] = (i == root ? q_root : q[links[i].parent]) * links[i].frame;
    if (links[i].kind == JointKind::hinge) return rotate(q[i], links[i].axis_B);
  }
  return {};
}

template <class S> bool nearly_zero(S x) { return real::abs(x) <= S(8) * real::epsilon<S>(); }

}  // namespace

template <class S> auto PlanarTree<S>::of(const Tree<S>& tree) -> std::optional<PlanarTree> {
  PlanarTree planar;
  std::vector<Quat<S>> attitudes;  // at coordinates 0
  for (int i = 0; i < static_cast<int>(tree.links().size()); ++i)
    if (!planar.add_link(tree, i, attitudes)) return std::nullopt;
  planar.state_.resize(planar.links_.size());
  return planar;
}

template <class S> bool PlanarTree<S>::add_link(const Tree<S>& tree, int i, std::vector<Quat<S>>& attitudes) {
  const Link<S>& link = tree.links()[i];
  const bool turns = link.kind == JointKind::hinge, slides = link.kind == JointKind::slider;
  if (link.joint < 0 || !(turns || slides || link.kind == JointKind::fixed)) return false;
  const Quat<S> q_parent = link.parent >= 0 ? attitudes[link.parent] : tree.root_attitude(i);
  if (link.parent < 0) {
    Plane plane;
    plane.normal = first_hinge_axis(tree, i, q_parent);
    const Vec3<S>& n = plane.normal;
    if (!(norm(n) > S(0.5))) return false;
    const S x = real::abs(n.x), y = real::abs(n.y), z = real::abs(n.z);
    const Vec3<S> least = x <= y && x <= z ? Vec3<S>{S(1), S(0), S(0)}
                          : y <= z         ? Vec3<S>{S(0), S(1), S(0)}
                                           : Vec3<S>{S(0), S(0), S(1)};
    const Vec3<S> across = cross(n, least);
    plane.e1 = (S(1) / norm(across)) * across;
    plane.e2 = cross(n, plane.e1);
    planes_.push_back(plane);
  }
  Constants c{};
  c.plane = static_cast<int>(planes_.size()) - 1;
  const Plane& plane = planes_.back();
  attitudes.push_back(q_parent * link.frame);
  const auto in_plane = [&](const Quat<S>& q, const Vec3<S>& v_B) {
    const Vec3<S> v = rotate(q, v_B);
    return Vec2{dot(v, plane.e1), dot(v, plane.e2)};
  };
  const Vec3<S> axis = rotate(attitudes.back(), link.axis_B);
  if (turns && !nearly_zero(norm(cross(axis, plane.normal)))) return false;
  if (slides && !nearly_zero(dot(axis, plane.normal))) return false;
  c.parent = link.parent;
  c.at_q = link.at_q;
  c.at_u = link.at_u;
  c.rate = link.first_rate;
  c.turns = turns;
  c.slides = slides;
  c.driven = link.driven;
  c.sign = dot(axis, plane.normal) < S(0) ? S(-1) : S(1);
  c.from_parent = in_plane(q_parent, link.from_parent_P);
  c.to_centre = in_plane(attitudes.back(), link.to_centre_B);
  c.axis = in_plane(attitudes.back(), link.axis_B);
  c.mass = link.mass_kg;
  const Vec3<S> normal_B = rotate_back(attitudes.back(), plane.normal);
  c.J = dot(normal_B, link.J_B * normal_B);
  c.driven_start = link.driven_start;
  c.driven_rate = link.driven_rate;
  links_.push_back(c);
  return true;
}

// Places, and the wrench of the motion at constant rates. Turning a vector by z multiplies complex numbers; the vector
// that a turn at unit rate gives to v is (-v.y, v.x).
template <class S> void PlanarTree<S>::move(S t_s, const S* y) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Constants& link = links_[i];
    State& m = state_[i];
    const Vec2 z0 = link.parent >= 0 ? state_[link.parent].z : Vec2{S(1), S(0)};
    const S w0 = link.parent >= 0 ? state_[link.parent].w : S(0);
    const S q = link.driven ? link.driven_start + t_s * link.driven_rate : y[link.at_q];
    const S u = link.driven ? link.driven_rate : y[link.at_u];
    m.d = {z0.x * link.from_parent.x - z0.y * link.from_parent.y,
           z0.x * link.from_parent.y + z0.y * link.from_parent.x};
    m.z = z0;
    m.w = w0;
    Vec2 drag{};
    if (link.turns) {
      S sine, cosine;
      real::sin_cos(q, sine, cosine);
      sine *= link.sign;
      m.z = {z0.x * cosine - z0.y * sine, z0.x * sine + z0.y * cosine};
      m.w = w0 + link.sign * u;
    } else if (link.slides) {
      m.s = {z0.x * link.axis.x - z0.y * link.axis.y, z0.x * link.axis.y + z0.y * link.axis.x};
      m.d.x += q * m.s.x;
      m.d.y += q * m.s.y;
      const S twice = S(2) * w0 * u;  // Coriolis: 2 w x s u
      drag = {-twice * m.s.y, twice * m.s.x};
    }
    m.c = {drag.x - w0 * w0 * m.d.x, drag.y - w0 * w0 * m.d.y};
    const Vec2 r{m.z.x * link.to_centre.x - m.z.y * link.to_centre.y,
                 m.z.x * link.to_centre.y + m.z.y * link.to_centre.x};
    m.J = link.J;
    m.h = {-link.mass * r.y, link.mass * r.x};
    m.Mxx = m.Myy = link.mass;
    m.Mxy = S(0);
    m.n = S(0);
    const S inwards = -link.mass * m.w * m.w;
    m.f = {inwards * r.x, inwards * r.y};
  }
}

template <class S> void PlanarTree<S>::eliminate(const S* applied) {
  for (int i = static_cast<int>(links_.size()) - 1; i >= 0; --i) {
    const Constants& link = links_[i];
    State& m = state_[i];
    if (link.turns && !link.driven) {
      m.inverse_D = S(1) / m.J;
      m.force = link.sign * applied[link.rate] - m.n;
      if (link.parent < 0) continue;
      const S share = m.force * m.inverse_D;
      const Vec2 k{m.inverse_D * m.h.x, m.inverse_D * m.h.y};
      const S Mxx = m.Mxx - k.x * m.h.x, Mxy = m.Mxy - k.x * m.h.y, Myy = m.Myy - k.y * m.h.y;
      const Vec2 f{m.f.x + share * m.h.x + Mxx * m.c.x + Mxy * m.c.y,
                   m.f.y + share * m.h.y + Mxy * m.c.x + Myy * m.c.y};
      State& to = state_[link.parent];
      const Vec2 g{Mxy * m.d.x - Mxx * m.d.y, Myy * m.d.x - Mxy * m.d.y};  // M (-d.y, d.x)
      to.J += m.d.x * g.y - m.d.y * g.x;
      to.h.x += g.x;
      to.h.y += g.y;
      to.Mxx += Mxx;
      to.Mxy += Mxy;
      to.Myy += Myy;
      to.n += link.sign * applied[link.rate] + (m.d.x * f.y - m.d.y * f.x);
      to.f.x += f.x;
      to.f.y += f.y;
      continue;
    }
    S J = m.J, n = m.n, Mxx = m.Mxx, Mxy = m.Mxy, Myy = m.Myy;
    Vec2 h = m.h, f = m.f;
    if (link.slides && !link.driven) {
      m.Un = h.x * m.s.x + h.y * m.s.y;
      m.Uf = {Mxx * m.s.x + Mxy * m.s.y, Mxy * m.s.x + Myy * m.s.y};
      m.inverse_D = S(1) / (m.s.x * m.Uf.x + m.s.y * m.Uf.y);
      m.force = applied[link.rate] - (m.s.x * f.x + m.s.y * f.y);
      const S share = m.force * m.inverse_D, k = m.inverse_D * m.Un;
      const Vec2 l{m.inverse_D * m.Uf.x, m.inverse_D * m.Uf.y};
      J -= k * m.Un;
      h = {h.x - k * m.Uf.x, h.y - k * m.Uf.y};
      Mxx -= l.x * m.Uf.x;
      Mxy -= l.x * m.Uf.y;
      Myy -= l.y * m.Uf.y;
      n += share * m.Un;
      f = {f.x + share * m.Uf.x, f.y + share * m.Uf.y};
    }
    if (link.parent < 0) continue;
    n += h.x * m.c.x + h.y * m.c.y;
    f = {f.x + Mxx * m.c.x + Mxy * m.c.y, f.y + Mxy * m.c.x + Myy * m.c.y};
    State& to = state_[link.parent];
    const Vec2 g{Mxy * m.d.x - Mxx * m.d.y, Myy * m.d.x - Mxy * m.d.y};
    const Vec2 sum{h.x + g.x, h.y + g.y};
    to.J += J + (m.d.x * h.y - m.d.y * h.x) + (m.d.x * sum.y - m.d.y * sum.x);
    to.h.x += sum.x;
    to.h.y += sum.y;
    to.Mxx += Mxx;
    to.Mxy += Mxy;
    to.Myy += Myy;
    to.n += n + (m.d.x * f.y - m.d.y * f.x);
    to.f.x += f.x;
    to.f.y += f.y;
  }
}

// Accelerations relative to free fall, so that gravity is an acceleration of the roots. A hinge gives alpha itself.
template <class S> void PlanarTree<S>::accelerate(const Vec3<S>& gravity_W, S* du) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Constants& link = links_[i];
    State& m = state_[i];
    S alpha0 = S(0);
    Vec2 a;
    if (link.parent >= 0) {
      const State& parent = state_[link.parent];
      alpha0 = parent.alpha;
      a = {parent.a.x - alpha0 * m.d.y + m.c.x, parent.a.y + alpha0 * m.d.x + m.c.y};
    } else {
      a = {-dot(gravity_W, planes_[link.plane].e1), -dot(gravity_W, planes_[link.plane].e2)};
    }
    m.alpha = alpha0;
    m.a = a;
    if (link.driven) {
      du[link.rate] = S(0);
    } else if (link.turns) {
      m.alpha = (m.force - (m.h.x * a.x + m.h.y * a.y)) * m.inverse_D;
      du[link.rate] = link.sign * (m.alpha - alpha0);
    } else if (link.slides) {
      const S rise = (m.force - (m.Un * alpha0 + (m.Uf.x * a.x + m.Uf.y * a.y))) * m.inverse_D;
      m.a = {a.x + rise * m.s.x, a.y + rise * m.s.y};
      du[link.rate] = rise;
    }
  }
}

template <class S>
void PlanarTree<S>::accelerations(S t_s, const S* y, const Vec3<S>& gravity_W, const S* applied, S* du) {
  move(t_s, y);
  eliminate(applied);
  accelerate(gravity_W, du);
}

template class PlanarTree<float>;
template class PlanarTree<double>;
template class PlanarTree<long double>;
template class PlanarTree<Quad>;

}  // namespace atwood
