// Fixed bodies with flat faces, and the contact of a ball on a parabola with them.
#pragma once

#include <functional>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Face {
  Vec<S> n{};             // unit, outwards
  S offset{};             // n . x on it
  bool infinite = false;  // of a plane
  Vec<S> center{}, side[2]{};
  S half[2]{};
};

template <class S> struct Obstacle {
  int body = -1;
  std::vector<Face<S>> faces;  // plane: one, rectangle: two, box: six
  Vec<S> center{}, axis[3]{};  // as a box; a rectangle is one of thickness 0
  S half[3]{};
};

// Appends a plane, a rectangle or a box. False: the body has another shape.
template <class S> bool add_obstacle(const Body& body, int at, std::vector<Obstacle<S>>& obstacles);

// Distance of a point; for a plane with a sign, for others 0 inside.
template <class S> S distance(const Obstacle<S>& obstacle, const Vec<S>& p);
template <class S> bool within_sides(const Face<S>& face, const Vec<S>& p);

// The first t >= 0 at which h + u t - a t^2 / 2 decreases through 0, and its speed there; negative: there is none.
// |h| <= contact_tolerance counts as 0.
template <class S> S descent_time(S h, S u, S a, S contact_tolerance, S& speed);

// A parabola with position p and velocity v at `from`.
template <class S> struct Arc {
  S from{}, until{};
  Vec<S> p{}, v{}, g{};
};

// Does gap(t) stay positive? Decided by bisection; between two times the gap changes by at most way(from, until). An
// interval whose gap is below `near` counts as a contact.
template <class S>
bool stays_positive(S from, S until, const std::function<S(S)>& gap, const std::function<S(S, S)>& way, S near);
// Does `distance` (1-Lipschitz) stay above `reach` along the arc, to 1e-9 of it?
template <class S> bool stays_clear(const Arc<S>& arc, S clearance, const std::function<S(const Vec<S>&)>& distance);
// Can the ball's first contact on the arc be with an edge or a corner? This needs a height over a face below its
// radius, outside of the sides of the face.
template <class S> bool may_meet_edge(const Obstacle<S>& obstacle, S radius, const Arc<S>& arc);

}  // namespace atwood::closed_form
