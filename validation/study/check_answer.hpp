// Checks of a worker's answer against the request, the scene's initial state and the wall clock. An answer that does
// not agree throws wire::Garbage, which names what was found, what was expected and a likely cause.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "protocol/wire.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Bodies that a sample has, and where they are at t = 0.
struct SampledBodies {
  SampledBodies(std::size_t bodies) : count(bodies) {}  // their initial state is not known
  explicit SampledBodies(const Scene& scene);

  struct Start {
    Real3 p_m{}, v_m_per_s{}, w_rad_per_s{};
    Real4 q_wxyz{1, 0, 0, 0};
    bool turns = false;  // has an inertia and is not fixed: its orientation is compared
    bool placed = true;  // has a position (a plane has none)
    bool still = false;  // fixed, or held until its release: its velocity may also be reported as 0
    bool moves = true;   // of bodies; a bare system of equations has positions only
  };
  std::size_t count = 0;
  std::size_t particles = 0;                     // of all fluids
  std::vector<Joint> joints = {};                // of the scene: a sample reports all of them, or none
  std::vector<std::size_t> rope_pulleys = {};    // of each rope
  std::vector<Real3> particle_start = {};        // where they are at t = 0
  std::vector<Start> start = {};                 // one per body, or none
  double size_m = 0;                             // the largest coordinate or bounding radius
  double speed_m_per_s = 0, rate_rad_per_s = 0;  // the largest of any body
  double gravity_m_per_s2 = 0;
};

// Sample 0 against the scene: positions, velocities and rates within this part of the largest of their kind in the
// scene, orientations of bodies that turn within it, up to sign. Engines that compute in float are within 1e-7 there.
inline constexpr double kStartTolerance = 1e-5;
// Norms of quaternions: of every body at t = 0, and of bodies that do not turn throughout.
inline constexpr double kNormTolerance = 1e-3;
// Later samples of bodies that turn: a method that integrates the quaternion without normalising it drifts away from
// norm 1, which the metric quaternion-norm-drift reports (the angle of an attitude does not show it). This is the limit
// for foreign engines. Engines built with this program have no limit: Euler's method at a coarse step reaches norm 16.
inline constexpr double kNormDrift = 0.1;

// Sample k = 0..samples of a run or a truth: its number of bodies and of particles, and its time.
void check_layout(const SampleView& sample, std::size_t k, double t_end_s, std::int64_t samples,
                  const SampledBodies& bodies);
// Joints and ropes of a sample: none, or those of the scene, with their coordinates and pulleys.
void check_joints(const wire::Answer& answer, const SampledBodies& bodies);
// The states of a run's sample k. Values that are not finite are refused at k = 0 only. `foreign`: of an engine that
// was not built with this program.
void check_states(const SampleView& sample, std::size_t k, double t_end_s, const SampledBodies& bodies, bool foreign);

// Why a run has diverged although all its values are finite: a body that moves farther between two samples, or is
// faster or turns faster, than kBlowUp times the scale of the scene; empty where no body does. The scale follows from
// the size and speeds of the initial state and from the fall under gravity during the run; 1 m where all are zero.
inline constexpr double kBlowUp = 1e12;
std::string blow_up(const SampleSeries& samples, double t_end_s, const SampledBodies& bodies);

// Times of a timed pass: one per repeat, each positive, their sum not longer than the wall time of the whole answer (5
// % and 1 ms are allowed for different clocks). For foreign engines also: at least 0.3 ns per step (our fastest fused
// kernels take about 2 ns a body and step).
void check_busy(const std::vector<std::int64_t>& busy_ns, int repeats, std::int64_t steps, std::int64_t wall_ns,
                bool foreign = false);

}  // namespace atwood
