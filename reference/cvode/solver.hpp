// A CVODE integrator with everything it owns. Its users need no SUNDIALS header.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cvode/trajectory.hpp"

namespace atwood::cvode {

enum class Family { adams, bdf };

// The unit of atol for each kind of component. A method's atol is in SI units; a truth's is relative to the scene's
// size.
struct Scales {
  double position_m = 1, velocity_m_per_s = 1, rate_rad_per_s = 1;
};

struct Options {
  Family family = Family::adams;
  double rtol = 1e-10, atol = 1e-12;
  Scales scales;
  bool newton = true;                // BDF: Newton with a dense matrix; false: fixed-point iteration, for large systems
  int max_order = 12;                // 5 at most for BDF
  std::int64_t max_steps = 2000000;  // of a whole run
  bool limit_per_segment = false;    // ... or of each segment between restarts
  int rate_repeats = 1;              // each rate is evaluated this many times and counted once
};

enum class Stop { reached, root, failed };

class Solver {
 public:
  using Rate = std::function<void(double t_s, const double* y, double* dydt)>;
  using Roots =
      std::function<void(double t_s, const double* y, double* g)>;  // a root is where one g falls through zero

  // `atol`: one per component of y. `rate` may be called with the same y again.
  Solver(const Options& options, const std::vector<double>& atol, Rate rate);
  ~Solver();
  Solver(const Solver&) = delete;

  // (Re)starts at order 1. Until the next start the equations are not evaluated after `stop_s`.
  void start(double t_s, const std::vector<double>& y, double stop_s, int roots, Roots g);
  // Integrates to `target_s` or to the first root before it, with interpolation; fills t_s and y. Stop::failed:
  // failure() says why, and y is not changed unless the state is not finite.
  Stop advance(double target_s, double& t_s, std::vector<double>& y);
  // One step of CVODE's own choice, at most to `stop_s` of start(). As advance() without roots; `path` becomes the
  // solution within the step.
  Stop step(double stop_s, double& t_s, std::vector<double>& y, Trajectory& path);
  const std::string& failure() const;
  bool not_finite() const;
  std::int64_t steps() const;
  std::int64_t rate_evaluations() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

std::string version();  // of the linked SUNDIALS

}  // namespace atwood::cvode
