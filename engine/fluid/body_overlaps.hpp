// Bodies that overlap: `+sph` has no contact between bodies, so a run ends in the step in which two begin to overlap.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "collision/geometry.hpp"
#include "rigid/model.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid {

// Pairs of bodies with shapes of which at least one can move and which no joint ties to each other, by the tests of
// collision/contacts.hpp, computed in double. Along a periodic axis the images of a body count,
// at most three to each side.
template <class S> class BodyOverlaps {
 public:
  // Keeps references to both.
  BodyOverlaps(const Scene& scene, const RigidModel<S>& bodies);

  // Why pairs of these shapes cannot be tested, or which two overlap at the start; empty: neither.
  const std::string& unsupported() const { return unsupported_; }
  // "the body `cube` ran into the boundary `floor` (...) at [0.5, 0] m", of the first pair that overlaps at t_s by more
  // than round-off; empty: none does. y: the bodies' part of the state.
  std::string found(S t_s, const S* y);

 private:
  struct Overlap {
    int a = -1, b = -1;  // indices into Scene::bodies; -1: none
    double depth_m = 0;
    Vec3<double> at_W;
  };
  void place(S t_s, const S* y);
  Overlap first_overlap() const;
  Overlap overlap_of(int a, int b) const;
  bool overlap_at(int a, int b, const Vec3<double>& shift, Overlap& found) const;
  std::string name(int body) const;
  std::string place_words(const Overlap& overlap) const;

  const Scene& scene_;
  const RigidModel<S>& bodies_;
  std::string unsupported_;
  std::vector<int> moving_, all_;  // bodies with a shape
  std::vector<Geometry<double>> shapes_;
  std::vector<Transform<double>> poses_;
  std::vector<std::pair<int, int>> joined_;  // smaller index first, sorted
};

}  // namespace atwood::fluid
