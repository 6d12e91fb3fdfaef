// Walls of dummy particles that carry the fluid's own values to their side: Adami, Hu, Adams, J. Comput. Phys. 231
// (2012) 7057; equations in docs/fluids.md.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fluid/particle_set.hpp"
#include "fluid/sums.hpp"
#include "rigid/model.hpp"

namespace atwood::fluid {

// Points follow the particles in Neighbours: wall point w is point `particles + w`.
template <class S> class Walls {
 public:
  // Keeps references to set, sums and bodies. Adds the fluid's load to the bodies.
  Walls(const Scene& scene, const ParticleSet<S>& set, const PairSums<S>& sums, RigidModel<S>* bodies);

  const std::string& unsupported() const { return unsupported_; }
  int count() const { return static_cast<int>(points_.size()); }
  const std::vector<S>& positions() const { return x_; }
  const FluidLaw<S>& law() const { return set_.laws.front(); }
  S mass() const { return law().density0 * volume_; }

  // Positions and velocities of the points when the bodies are at y.
  void place(S t_s, const S* y_bodies);
  // Velocity, pressure and temperature of the points from the particles around them. Records and densities are by slot;
  // y is the state.
  void extrapolate(const Neighbours<S>& lists, const S* records, const S* densities, const S* y);
  // Adds to the sums of the particles in the blocks [first, last).
  void add_forces(const Neighbours<S>& lists, const S* records, const S* densities, const S* y, int first, int last,
                  S* sums) const;
  // Keeps what the particles exert on the bodies, for the rate of the bodies that follows.
  void load_bodies(const Neighbours<S>& lists, const S* records, const S* densities, const S* y);
  // The name of a fixed boundary that a particle at x has passed by more than one spacing; empty: none.
  std::string boundary_behind(const S* x) const;
  // Whether boundary_behind() may name one for some particle: false only where it names none. Two or three comparisons
  // a particle and box or ball, and none a plane but for the extent of all particles.
  bool some_may_be_behind(const S* x) const;

 private:
  struct Point {
    int boundary, body;
    Vec3<S> at;  // world of a fixed body, else its axes
    S power;     // of a given flux through the point's part of the surface
  };
  struct Barrier {  // around the points that are deeper than a spacing behind a fixed boundary
    bool plane;
    S low[3], high[3];  // of a plane infinite but for one
  };
  void add_barrier(const Body& body);
  template <int d> bool some_may_be_behind(const S* x) const;
  struct WallPairTerms;  // what a wall point does to a particle
  WallPairTerms wall_pair_terms(const Neighbours<S>& lists, const S* records, const S* densities, const S* y, int slot,
                                int wall_slot) const;
  struct FluidLoad;

  const Scene& scene_;
  const ParticleSet<S>& set_;
  const PairSums<S>& sums_;
  RigidModel<S>* bodies_;
  std::string unsupported_;
  S volume_{}, half_lattice_sum_{}, gravity_[3]{};
  std::vector<Point> points_;
  std::vector<Barrier> barriers_;
  std::vector<S> x_, u_;                                             // positions, velocities of the surface: d a point
  std::vector<S> weight_, slip_, pressure_, density_, temperature_;  // of the points: sum of W; v~ (d); p; rho; T~
  std::vector<S> heating_;      // [W] heat entering through a point, divided by its sum of V W
  std::vector<Load<S>> loads_;  // one a body
  std::int64_t flagged_build_ = -1;
  std::vector<char> near_wall_;  // one a block: some particle of it has a wall point in its list
};

}  // namespace atwood::fluid
