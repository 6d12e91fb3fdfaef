#include "joints/planar_rates_kernel.hpp"

#include <algorithm>

namespace atwood {
namespace {

constexpr std::size_t kLeastHingesOfPack = 4;  // fewer are quicker one by one

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

template <class S> auto PlanarRates<S>::of(const Tree<S>& tree) -> std::optional<PlanarRates> {
  PlanarRates planar;
  std::vector<Quat<S>> attitudes;  // at coordinates 0
  for (int i = 0; i < static_cast<int>(tree.links().size()); ++i)
    if (!planar.add_link(tree, i, attitudes)) return std::nullopt;
  planar.state_.resize(planar.links_.size());
  if constexpr (PackOf<S>::in_register) planar.lanes_.resize(planar.links_.size());
  return planar;
}

// Mechanisms of parallel planes share their axes. -1: the normal is none.
template <class S> int PlanarRates<S>::plane_across(const Vec3<S>& n) {
  if (!(norm(n) > S(0.5))) return -1;
  for (std::size_t i = 0; i < planes_.size(); ++i)
    if (nearly_zero(norm(cross(n, planes_[i].normal)))) return static_cast<int>(i);
  const S x = real::abs(n.x), y = real::abs(n.y), z = real::abs(n.z);
  const Vec3<S> least = x <= y && x <= z ? Vec3<S>{S(1), S(0), S(0)}
                        : y <= z         ? Vec3<S>{S(0), S(1), S(0)}
                                         : Vec3<S>{S(0), S(0), S(1)};
  const Vec3<S> across = cross(n, least), e1 = (S(1) / norm(across)) * across;
  planes_.push_back({e1, cross(n, e1), n});
  return static_cast<int>(planes_.size()) - 1;
}

template <class S> bool PlanarRates<S>::add_link(const Tree<S>& tree, int i, std::vector<Quat<S>>& attitudes) {
  const Link<S>& link = tree.links()[i];
  const bool turns = link.kind == JointKind::hinge, slides = link.kind == JointKind::slider;
  if (link.joint < 0 || !(turns || slides || link.kind == JointKind::fixed)) return false;
  const Quat<S> q_parent = link.parent >= 0 ? attitudes[link.parent] : tree.root_attitude(i);
  Constants c{};
  c.plane = link.parent >= 0 ? links_[link.parent].plane : plane_across(first_hinge_axis(tree, i, q_parent));
  if (c.plane < 0) return false;
  const Plane& plane = planes_[c.plane];
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
  if (turns) hinges_.push_back(static_cast<int>(links_.size()));
  links_.push_back(c);
  return true;
}

// (cos, sin) of what each hinge turns its link by, into the link's z: several at once, with the bits of each. False:
// there are too few for it.
template <class S> bool PlanarRates<S>::turn_hinges(const OneState<S>& y, State<S>* state, DrivenJoints driven) const {
  if constexpr (PackOf<S>::in_register) {
    if (hinges_.size() < kLeastHingesOfPack) return false;
    in_lanes<S>(widest_vectors(), [&](auto width) ATWOOD_INLINED {
      using P = PackAt<S, decltype(width)::value>;
      for (std::size_t at = 0; at < hinges_.size(); at += kLaneCount) {
        const std::size_t count = std::min<std::size_t>(kLaneCount, hinges_.size() - at);
        LaneBlock<S> q{}, sine, cosine;
        for (std::size_t k = 0; k < count; ++k) q.lane[k] = coordinate(links_[hinges_[at + k]], y, driven);
        P sines, cosines;
        real::same_sin_cos(load_as<P>(q.lane), sines, cosines);
        store<S>(sines, sine.lane);
        store<S>(cosines, cosine.lane);
        for (std::size_t k = 0; k < count; ++k) {
          const int i = hinges_[at + k];
          state[i].z = {cosine.lane[k], links_[i].sign * sine.lane[k]};
        }
      }
    });
    return true;
  }
  return false;
}

template <class S> void PlanarRates<S>::rates(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied) {
  const bool turned = turn_hinges(y, state_.data());
  run_scalar<S>(widest_vectors(), [&]() ATWOOD_INLINED {
    outward_pass(y, turned, state_.data());
    inward_pass(applied, static_cast<int>(links_.size()), state_.data());
    acceleration_pass(y, gravity_W, state_.data());
  });
}

template <class S>
void PlanarRates<S>::rates(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W,
                           const LaneBlock<S>* applied) {
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      const auto states = y.template at_width<at>();
      auto* work = lanes_.template at<at>().data();
      outward_pass(states, false, work);
      inward_pass(LaneValues<PackAt<S, at>>{lanes_of(applied)}, static_cast<int>(links_.size()), work);
      acceleration_pass(states, gravity_W, work);
    });
}

template class PlanarRates<float>;
template class PlanarRates<double>;
template class PlanarRates<long double>;
template class PlanarRates<Quad>;

}  // namespace atwood
