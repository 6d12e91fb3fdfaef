// Fixed flat-faced things that balls may hit, and what a ball on a parabola keeps clear of.
#pragma once

#include <functional>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Face {
  Vec<S> n{};            // unit, outwards
  S offset{};            // n . x on it
  bool endless = false;  // a plane's
  Vec<S> center{}, side[2]{};
  S half[2]{};
};

template <class S> struct Obstacle {
  int body = -1;
  std::vector<Face<S>> faces;  // one of a plane, two of a rectangle, six of a box
  Vec<S> center{}, axis[3]{};  // as a box; a rectangle is one of thickness 0
  S half[3]{};
};

// False: the shape is none of a plane, a rectangle and a box.
template <class S> bool add_obstacle(const Body& body, int at, std::vector<Obstacle<S>>& obstacles);

// From a point to the obstacle; of a plane: signed, of others 0 inside.
template <class S> S distance(const Obstacle<S>& obstacle, const Vec<S>& p);
template <class S> bool within_sides(const Face<S>& face, const Vec<S>& p);

// The first t >= 0 at which h + u t - a t^2 / 2 passes 0 downwards, and how fast; negative: never. A height within
// `touching` of 0 is 0.
template <class S> S descends(S h, S u, S a, S touching, S& speed);

// p, v at `from`
template <class S> struct Arc {
  S from{}, until{};
  Vec<S> p{}, v{}, g{};
};

// Does gap(t) stay above 0? Decided by halving: between two instants it changes by way(from, until) at most. An
// approach nearer than `near` counts as none.
template <class S>
bool stays_open(S from, S until, const std::function<S(S)>& gap, const std::function<S(S, S)>& way, S near);
// Does `distance` along the arc stay above `reach`, to 1e-9 of it? It changes no faster than the point moves.
template <class S> bool stays_clear(const Arc<S>& arc, S reach, const std::function<S(const Vec<S>&)>& distance);
// May a ball's first touch on the arc be an edge or a corner? Only where it is lower over a face than its radius and
// beyond that face's sides.
template <class S> bool meets_an_edge(const Obstacle<S>& obstacle, S radius, const Arc<S>& arc);

}  // namespace atwood::closed_form
