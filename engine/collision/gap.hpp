// Which bodies can touch, and how far apart their surfaces are: spheres against spheres and planes.
#pragma once

#include <string>
#include <vector>

#include "math/vec3.hpp"
#include "scene/scene.hpp"

namespace atwood {

template <class S> struct ContactPair {
  int a = 0, b = 0;                       // a < b
  bool plane_a = false, plane_b = false;  // at most one of them; the other (or both) a sphere
  S radius_a{}, radius_b{};
  Vec3<S> plane_normal;  // unit
  S plane_offset{};      // n . x = offset on the plane
  S restitution{}, friction{};
};

// Surface to surface: negative when they overlap. The normal points from a to b, the point lies midway.
template <class S> struct Gap {
  S distance{};
  Vec3<S> normal_W, point_W;
};

// Every pair that may touch. Where the scene has a pair that this engine has no test for, `why` says which.
template <class S> std::vector<ContactPair<S>> contact_pairs(const Scene& scene, std::string& why);

template <class S> Gap<S> gap_between(const ContactPair<S>& pair, const Vec3<S>& p_a, const Vec3<S>& p_b);

}  // namespace atwood
