// The free surface of `+polynomial`: nodes that the fluid carries along, where the pressure is 0 (docs/fluids.md, "Free
// surface").
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fluid/particle_set.hpp"
#include "fluid/polynomial_fit.hpp"
#include "fluid/polynomial_nodes.hpp"

namespace atwood::fluid {

// Nodes that are at most 1.6 spacings apart at t = 0 may come this far apart [spacings].
inline constexpr double kMaxSpacingsOfNeighbours = 1.6, kMaxSpacingsStretched = 3;

template <class S> class PolynomialSurface {
 public:
  // support: R of the fits. No nodes: the scene has no free surface.
  PolynomialSurface(const Scene& scene, const ParticleSet<S>& set, KernelShape shape, S support);

  const std::string& unsupported() const { return unsupported_; }
  int count() const { return static_cast<int>(start_.size()) / dimensions_; }
  const std::vector<S>& start() const { return start_; }  // positions at t = 0
  S support() const { return fits_.support; }
  // Records and weights of the nodes' slots, from those of the particles; rates: velocities of the nodes. `first`: the
  // nodes' first point in the lists. False: some node has too few particles around it, named by fault().
  bool fill(const Neighbours<S>& lists, int first, S* records, SlotWeight<S>* weights, S* rates);
  // Why nodes at x do not describe a surface any more; empty: they do.
  std::string fault(const S* x) const;

 private:
  const ParticleSet<S>& set_;
  int dimensions_;
  bool alone_ = false;  // in the last rate a node, at alone_at_, had too few particles around it
  S alone_at_[3]{};
  S spacing_{};
  NodeFits<S> fits_;
  NodeWeights<S> around_;
  std::string unsupported_;
  std::vector<S> start_;
  std::vector<std::pair<int, int>> near_;
};

}  // namespace atwood::fluid
