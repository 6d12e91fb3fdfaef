// `+sph`: weakly compressible smoothed particle hydrodynamics, pairwise (docs/fluids.md).
#pragma once

#include <memory>
#include <vector>

#include "fluid/body_acceleration.hpp"
#include "fluid/particle_set.hpp"
#include "fluid/particle_system.hpp"
#include "fluid/sums.hpp"
#include "parallel/team.hpp"
#include "rigid/model.hpp"

namespace atwood::fluid {

template <class S> class BodyOverlaps;
template <class S> class Walls;

struct SphOptions {
  KernelShape kernel = KernelShape::wendland_c2;
  double smoothing = 1.3;  // h over the particles' spacing
  bool summation = false;  // density by summation; else by continuity
  Viscosity viscosity = Viscosity::morris;
  double density_diffusion = 0, shift = 0;  // below 0: by the scene
  bool corrected = false;
  int threads = 1;
  double skin = 0.12;         // of the support; results do not depend on it
  bool lane_by_lane = false;  // the scalar loop; the same bits
};

// With `shift` and `density_diffusion` below 0 replaced by what they stand for in this scene (docs/fluids.md).
SphOptions resolved(SphOptions options, const Scene& scene);

template <class S> class Sph final : public ParticleSystem<S> {
 public:
  Sph(const Scene& scene, const SphOptions& asked);
  ~Sph() override;
  Sph(const Sph&) = delete;
  Sph& operator=(const Sph&) = delete;

  const std::string& unsupported() const override { return unsupported_; }
  const Layout& layout() const override { return set_.layout; }
  System<S>& system() override { return system_; }
  void initial_state(S* y) const override;
  void write(S t_s, const S* y, Sample& sample) override;
  std::string fault(const S* y) const override;
  std::string lost(S t_s, const S* y) override;
  std::string not_separable() const override;
  Team* team() override { return team_.get(); }
  void accelerations(S t_s, const S* y, S* acceleration) override;

  const ParticleSet<S>& particles() const { return set_; }
  const Kernel<S>& kernel() const { return sums_.kernel; }
  const Neighbours<S>& neighbours() const { return *lists_; }
  const SphOptions& options() const { return options_; }
  std::vector<S> densities(const S* y);  // one a particle: the state's, or summed
  S mean_neighbours(const S* y);         // within the support, of a fluid particle, walls included

 private:
  static void rate_of(void* context, S t_s, const S* y, S* dydt);
  static void project_of(void* context, S* y);
  bool update(S t_s, const S* y);  // lists and records at a state; false: some position is not finite
  template <int d> void pack(const S* y, int first_block, int last_block);
  void set_masses();
  template <int d> void set_pressures(const S* y, int first_block, int last_block);
  void set_heat_records(const S* y, int first_block, int last_block);
  template <int d> void rate_of_particles(S t_s, const S* y, S* dydt, int first_slot, int last_slot) const;
  template <class Work> void over_blocks(const Work& work);
  SlotData<S> slot_data() const;
  template <class Finish> void over_sums(const S* y, const Finish& finish);
  void set_corrections();
  void set_transport(const S* y);
  std::string went_through(const S* y, int particle) const;

  const Scene& scene_;
  SphOptions options_;
  std::string unsupported_;
  ParticleSet<S> set_;
  std::vector<BodyAcceleration<S>> sources_;  // one a fluid; empty: no fluid has one
  std::unique_ptr<Team> team_;
  std::unique_ptr<RigidModel<S>> bodies_;      // null: no bodies
  std::unique_ptr<Walls<S>> walls_;            // null: no boundary
  std::unique_ptr<BodyOverlaps<S>> overlaps_;  // null: no body moves
  std::unique_ptr<Neighbours<S>> lists_;
  PairSums<S> sums_;
  System<S> system_;
  S gravity_[3]{}, transport_strength_{};  // shift U R
  bool needs_heat_record_ = false, equal_masses_ = false, equal_viscosities_ = false;
  std::vector<S> points_;  // positions of particles and walls, where there are walls
  LaneArray<S> records_;   // one block a slot (Record)
  std::vector<S> heat_, masses_, wall_masses_, viscosities_, densities_, out_;  // by slot
  std::vector<S> pressures_, temperatures_, transport_, carried_heat_;          // of corrections, by slot
};

}  // namespace atwood::fluid
