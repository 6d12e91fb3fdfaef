// Gaps of loops in planes to more digits than the state has.
#include "joints/planar_loops.hpp"

namespace atwood {

// One Newton step with the factors at y and gaps in the wider scalar. y is already within its tolerance; afterwards
// only its rounding is left.
template <class S> void PlanarLoops<S>::refine_positions(S* y) {
  if constexpr (!std::is_same_v<S, Quad>) {
    using W = WideScalar;
    for (std::size_t i = 0; i < wide_poses_.size(); ++i) {
      const auto& link = planar_.links_[i];
      WideLinkPose& to = wide_poses_[i];
      WideLinkPose from;
      from.x = W(bodies_[i].origin.x), from.y = W(bodies_[i].origin.y);
      if (link.parent >= 0) from = wide_poses_[link.parent];
      to = from;
      W along, across;
      from.turn(link.from_parent, along, across);
      to.x += along, to.y += across;
      if (link.turns) {
        to.angle += W(link.sign) * W(y[link.at_q]);
        real::sin_cos(to.angle, to.sine, to.cosine);
      } else if (link.slides) {
        from.turn(link.axis, along, across);
        to.x += W(y[link.at_q]) * along, to.y += W(y[link.at_q]) * across;
      }
    }
    for (int e = 0; e < chosen_; ++e) {
      const Equation& equation = equations_[e];
      W gap = W(0);
      for (int k = 0; k < 2; ++k) {
        const End& end = closings_[equation.closing].end[k];
        W x = W(end.point.x), z = W(end.point.y);
        if (end.link >= 0) {
          const WideLinkPose& pose = wide_poses_[end.link];
          pose.turn(end.point, x, z);
          x += pose.x, z += pose.y;
        }
        gap += W(k == 0 ? -1 : 1) * (x * W(equation.direction.x) + z * W(equation.direction.y));
      }
      b_[e] = -scale_[e] * S(gap);
    }
    change(y, false);
  }
}

template void PlanarLoops<float>::refine_positions(float*);
template void PlanarLoops<double>::refine_positions(double*);
template void PlanarLoops<long double>::refine_positions(long double*);
template void PlanarLoops<Quad>::refine_positions(Quad*);

}  // namespace atwood
