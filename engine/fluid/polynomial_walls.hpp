// Walls of `+polynomial`: nodes on the surfaces of fixed planes, whose values are given or extrapolated from the fluid
// (docs/fluids.md, "Walls").
#pragma once

#include <string>
#include <vector>

#include "fluid/particle_set.hpp"
#include "fluid/polynomial_fit.hpp"
#include "fluid/polynomial_nodes.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid {

// Degree of the polynomials without a condition that extrapolate to nodes for fits of degree 4; for fits of degree 2 it
// is 2. On a lattice the particles beside a wall stand in four layers, which do not determine a fourth power. Where the
// slope is given, the first power is known, and the degree is that of the fits: an error e of a node's value acts as a
// flux e / D through the wall, so that degree 3 would leave an error of order 3.
inline constexpr int kWallDegree = 3;

template <class S> class PolynomialWalls {
 public:
  // support: R of a particle far from walls; degree: of the fits.
  PolynomialWalls(const Scene& scene, const ParticleSet<S>& set, KernelShape shape, int degree, S support);

  const std::string& unsupported() const { return unsupported_; }
  // Number of wall points: the nodes, then dummy particles that only shifting uses. Point w of the walls is point
  // `particles + w` of the lists.
  int count() const { return static_cast<int>(positions_.size()) / dimensions_; }
  const std::vector<S>& positions() const { return positions_; }
  S widest_support() const { return fits_.support; }
  // R at a position (wrapped or not): wider near walls, where half of the neighbours is missing.
  S support_at(const S* x) const;
  // Records and weights of the slots of walls, from those of the particles.
  void fill(const Neighbours<S>& lists, S* records, SlotWeight<S>* weights) const;
  // The name of a boundary behind which x stands, deeper than half a spacing; null: none.
  const std::string* boundary_behind(const S* x) const;

 private:
  struct Wall {
    int body, axis;
    S sign, offset;  // the surface: sign x[axis] = offset; the normal points into the fluid
    S velocity[3];
    bool no_slip, has_temperature;
    S temperature, slope;  // of the temperature along the normal: - flux / conductivity
  };

  // Whether some particle in front of all walls takes a point at x into its sum for shifting.
  bool is_reached(const Real3& x) const;

  const Scene& scene_;
  const ParticleSet<S>& set_;
  int dimensions_, nodes_ = 0;
  S spacing_{}, support_{};
  NodeFits<S> fits_;
  std::string unsupported_;
  std::vector<Wall> walls_;
  std::vector<int> wall_of_;  // of a node
  std::vector<S> positions_;
};

}  // namespace atwood::fluid
