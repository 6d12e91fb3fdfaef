// Bodies at rest and the points where they touch, for the search of an equilibrium.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "closed_form/equilibrium.hpp"
#include "closed_form/number.hpp"
#include "scene/scene.hpp"

namespace atwood::closed_form {

inline double length(const Vec<double>& v) { return std::sqrt(dot(v, v)); }

// A box, a rectangle (a box of thickness 0), a sphere (a box of zero extent with a radius), or a plane.
struct RestingBody {
  Vec<double> center{}, axis[3]{};
  std::vector<Vec<Wide>> faces;  // normals of its faces, in quad; none of a sphere
  double half[3]{}, radius = 0, offset = 0;
  bool plane = false, free = false;
  double inverse_mass = 0;
  Real33 inertia_inverse{};  // diagonal, body axes
};

// A point of contact, n from a to b.
struct RestingContact {
  int a = 0, b = 0;
  Vec<double> x{}, n{};
  double friction = 0;    // reduced by the margins
  Wide slope{}, limit{};  // tangent of the angle between gravity and the normal; the coefficient of friction itself
  bool holds_weight() const { return slope * (1 + Wide(0x1p-108)) <= limit; }  // gravity lies in the cone
};

// Bound of the distance of its points from its centre.
double bounding_radius(const RestingBody& body);

// Sets `bodies`, `contacts`, and the extents in `made`. The reason for a refusal, or "".
std::string find_contacts_at_rest(const Scene& scene, std::vector<RestingBody>& bodies,
                                  std::vector<RestingContact>& contacts, Equilibrium& made);

}  // namespace atwood::closed_form
