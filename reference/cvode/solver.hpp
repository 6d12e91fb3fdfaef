// A CVODE memory block with everything it owns. No SUNDIALS header is needed by those who use it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace atwood::cvode {

enum class Family { adams, bdf };

// What atol is relative to, of each kind of component. A method's atol is in SI units; a truth's follows the scene.
struct Scales {
  double position_m = 1, velocity_m_per_s = 1, rate_rad_per_s = 1;
};

struct Options {
  Family family = Family::adams;
  double rtol = 1e-10, atol = 1e-12;
  Scales scales;
  int max_order = 12;                // 5 at most for BDF
  std::int64_t max_steps = 2000000;  // of a whole run
  bool per_stretch = false;          // ... or of each stretch between restarts
  int rate_repeats = 1;              // each evaluation is made so many times over and counts once
};

enum class Stop { reached, root, failed };

class Solver {
 public:
  using Rate = std::function<void(double t_s, const double* y, double* dydt)>;
  using Roots = std::function<void(double t_s, const double* y, double* g)>;  // found where g falls through zero

  // `atol`: one a component.
  Solver(const Options& options, const std::vector<double>& atol, Rate rate);
  ~Solver();
  Solver(const Solver&) = delete;

  // (Re)starts at order 1. No later than `stop_s` are the equations evaluated until the next start.
  void start(double t_s, const std::vector<double>& y, double stop_s, int roots, Roots g);
  // Goes to `target_s` or to the first root before it, interpolating; fills t_s and y.
  Stop advance(double target_s, double& t_s, std::vector<double>& y);
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
