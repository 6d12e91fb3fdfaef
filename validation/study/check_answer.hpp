// What a worker's answer must agree with: the request, the scene's initial state, the clock on the wall. Whatever does
// not is wire::Garbage, which names what was found and what was expected, and the likely slip.
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
  SampledBodies(std::size_t bodies) : count(bodies) {}  // nothing is known of their start
  explicit SampledBodies(const Scene& scene);

  struct Start {
    Real3 p_m{}, v_m_per_s{}, w_rad_per_s{};
    Real4 q_wxyz{1, 0, 0, 0};
    bool turns = false;  // has an inertia and is not fixed: its orientation is compared
    bool placed = true;  // has a position: a plane has none
    bool still = false;  // fixed, or held until its release: it may also be told as standing still
    bool moves = true;   // of bodies; a bare system of equations has a position alone
  };
  std::size_t count = 0;
  std::size_t particles = 0;                     // of all fluids
  std::vector<Real3> particle_start = {};        // where they are at t = 0
  std::vector<Start> start = {};                 // one a body, or none
  double size_m = 0;                             // the largest coordinate or bounding radius
  double speed_m_per_s = 0, rate_rad_per_s = 0;  // the largest of any body
  double gravity_m_per_s2 = 0;
};

// Sample 0 against the scene: positions, velocities and rates within this part of the largest of their kind in the scene,
// orientations of bodies that turn within it, up to sign. Engines that compute in float are within 1e-7 there.
inline constexpr double kStartTolerance = 1e-5;
// Norms of quaternions: of every body at t = 0, and of bodies that do not turn throughout.
inline constexpr double kNormTolerance = 1e-3;
// Later samples of bodies that turn: a method that integrates the quaternion without normalising it drifts away from
// norm 1, which the metric quaternion-norm-drift reports (the angle of an attitude does not show it). Foreign engines may
// drift this far. Engines built with this program are not bounded: Euler's method at a coarse step reaches norm 16.
inline constexpr double kNormDrift = 0.1;

// Sample k = 0..samples of a run or a truth: its number of bodies and of particles, and its time.
void check_layout(const Sample& sample, std::size_t k, double t_end_s, std::int64_t samples,
                  const SampledBodies& bodies);
// The states of a run's sample k. Values that are not finite are refused at k = 0 alone. `foreign`: of an engine that was
// not built with this program.
void check_states(const Sample& sample, std::size_t k, double t_end_s, const SampledBodies& bodies, bool foreign);

// Why a run has diverged although all its values are finite: a body that moves farther between two samples, or is faster or
// turns faster, than kBlowUp times what the initial state makes likely; empty: nothing does. What the initial state tells
// is its size, its speed and gravity over the run; where all are zero, 1 m.
inline constexpr double kBlowUp = 1e12;
std::string blow_up(const std::vector<Sample>& samples, double t_end_s, const SampledBodies& bodies);

// Times of a timed pass: one a repeat, each positive, together not longer than the whole answer took on the wall (5 %
// and 1 ms are allowed for two clocks). Of a foreign engine also: not less than 0.3 ns a step (our fastest fused kernels
// take about 2 ns a body and step).
void check_busy(const std::vector<std::int64_t>& busy_ns, int repeats, std::int64_t steps, std::int64_t wall_ns,
                bool foreign = false);

}  // namespace atwood
