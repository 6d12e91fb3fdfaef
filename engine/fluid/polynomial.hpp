// `+polynomial`: weakly compressible flow with derivatives by moving least squares, on shifted particles
// (docs/fluids.md).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fluid/body_acceleration.hpp"
#include "fluid/particle_set.hpp"
#include "fluid/particle_system.hpp"
#include "fluid/polynomial_fit.hpp"
#include "fluid/polynomial_surface.hpp"
#include "fluid/polynomial_walls.hpp"
#include "parallel/team.hpp"
#include "rigid/model.hpp"

namespace atwood::fluid {

struct PolynomialOptions {
  int degree = 4;  // of the fitted polynomials: 2 or 4
  KernelShape kernel = KernelShape::wendland_c2;
  double smoothing = 0;  // h over the particles' spacing; 0: 1.5 (degree 2), 1.55 (degree 4); free surface: 1.75
  double shift = -1;     // of the shifting velocity; 0: none; < 0: 1, with a free surface 0
  double shift_speed_m_per_s = 0;  // U of docs/fluids.md; 0: as said there
  double filter = -1;              // of the filter of grid-scale noise; < 0: 0.005, 0.1; 1
  int threads = 1;
  double skin = 0.08;         // of the support; results do not depend on it
  bool lane_by_lane = false;  // the scalar loop; the same bits
};
// With the values for the degree, or for a free surface, in place of the placeholders above.
PolynomialOptions resolved(PolynomialOptions options, bool free_surface);

// A pivot of a fit's scaled normal equations below this (a variance inflation factor above 250, of degree 2 1000) is a
// neighbourhood that does not determine the polynomial.
constexpr double least_pivot(int degree) { return degree == 2 ? 1e-3 : 4e-3; }

template <class S> class Polynomial final : public ParticleSystem<S> {
 public:
  Polynomial(const Scene& scene, const PolynomialOptions& options);
  Polynomial(const Polynomial&) = delete;
  Polynomial& operator=(const Polynomial&) = delete;

  const std::string& unsupported() const override { return unsupported_; }
  const Layout& layout() const override { return set_.layout; }
  System<S>& system() override { return system_; }
  void initial_state(S* y) const override;
  void write(S t_s, const S* y, Sample& sample) override;
  // Also names the particle whose neighbourhood did not determine its polynomial, with its condition number.
  std::string fault(const S* y) const override;
  std::string lost(S t_s, const S* y) override;

  const ParticleSet<S>& particles() const { return set_; }
  const PolynomialOptions& options() const { return options_; }
  const Neighbours<S>& neighbours() const { return *lists_; }
  S mean_neighbours(const S* y);  // within the support

 private:
  static void rate_of(void* context, S t_s, const S* y, S* dydt);
  bool update(const S* y);  // lists at a state; false: some position is not finite
  void pack(const S* y, int first_block, int last_block);
  bool holds_a_particle(int block) const;  // else it holds points of walls and of the surface, which take no fit
  std::string went_through(const S* y, int particle) const;
  void rate_of_particles(S t_s, const S* y, S* dydt, int first_slot, int last_slot, int& singular) const;

  const Scene& scene_;
  PolynomialOptions options_;
  std::string unsupported_;
  ParticleSet<S> set_;
  BodyAcceleration<S> source_;
  std::unique_ptr<Team> team_;
  std::unique_ptr<RigidModel<S>> bodies_;          // fixed ones; null: no bodies
  std::unique_ptr<PolynomialWalls<S>> walls_;      // null: no boundary
  std::unique_ptr<PolynomialSurface<S>> surface_;  // null: no free surface
  std::unique_ptr<Neighbours<S>> lists_;
  PolynomialFits<S> fits_;
  System<S> system_;
  S gravity_[3]{};
  S support_{}, shift_factor_{};
  std::vector<S> filter_rate_;          // F c / D of each fluid [1/s]
  std::vector<S> points_;               // positions of particles, walls and nodes of the surface, where there are some
  std::vector<S> records_, supports_;   // by slot
  std::vector<SlotWeight<S>> weights_;  // by slot, where there are walls or a surface
  std::vector<Fit<S>> fits_of_;         // by slot
  std::vector<LaneArray<S>> scratch_;   // one a part
  std::vector<int> singular_;           // one a part: a slot whose fit is singular; -1: none
  mutable int faulty_ = -1;             // a particle whose fit was singular in some rate
  S faulty_pivot_{};
};

}  // namespace atwood::fluid
