// Trees that move in planes: all hinges of a mechanism have parallel axes, its sliders move across them, and it hangs on
// something at rest. Forces across the plane and moments in it make reactions and no motion, and of the inertia only the
// moment about the axis of the hinges counts, so the articulated-body algorithm of joints/tree.hpp works with vectors of
// two components: an inertia about a point is a moment J, a coupling h and a 2x2 mass M,
//   n = J alpha + h . a + n0        f = alpha h + M a + f0
// Eliminating a hinge leaves neither J nor h: only M - h h^T / J.
#pragma once

#include <optional>
#include <vector>

#include "joints/tree.hpp"

namespace atwood {

template <class S> class PlanarTree {
 public:
  // Null where some mechanism of the tree does not move in a plane to the round-off of S, or a body is free.
  static std::optional<PlanarTree> of(const Tree<S>& tree);

  // u' of all rates, as Tree::accelerations() gives them under uniform gravity and the generalised forces `applied`
  // (Tree::rate_count() of each).
  void accelerations(S t_s, const S* y, const Vec3<S>& gravity_W, const S* applied, S* du);

 private:
  struct Vec2 {
    S x{}, y{};
  };
  struct Constants {
    int parent, at_q, at_u, rate, plane;
    bool turns, slides, driven;
    S sign;  // of a hinge's axis along the plane's normal
    Vec2 from_parent, to_centre, axis;
    S mass, J, driven_start, driven_rate;
  };
  struct State {
    Vec2 z, d, s, c;  // z: (cos, sin) of the link's turn; d, c as in LinkMotion; s: a slider's axis
    S w, J, Mxx, Mxy, Myy, n;
    Vec2 h, f;
    S inverse_D, force, Un;  // of the rate's elimination
    Vec2 Uf;
    S alpha;
    Vec2 a;
  };
  struct Plane {
    Vec3<S> e1, e2, normal;
  };

  bool add_link(const Tree<S>& tree, int i, std::vector<Quat<S>>& attitudes);
  void move(S t_s, const S* y);
  void eliminate(const S* applied);
  void accelerate(const Vec3<S>& gravity_W, S* du);

  std::vector<Constants> links_;
  std::vector<State> state_;
  std::vector<Plane> planes_;
};

}  // namespace atwood
