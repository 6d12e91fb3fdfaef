// One formulation of a mechanism with its integrator, behind one interface: what the path of a motion needs of it.
#pragma once

#include <memory>
#include <string>

#include "extended/problem.hpp"
#include "mechanism/maximal.hpp"

namespace atwood::extended {

class MechanismMotion {
 public:
  virtual ~MechanismMotion() = default;
  virtual int size() const = 0;
  virtual std::vector<Wide> initial(const Sample& start) const = 0;
  virtual const std::vector<double>& switch_times() const = 0;
  virtual std::unique_ptr<Stepper<Wide>> make_stepper(double tolerance) = 0;
  virtual mechanism::StepChoice& choice() = 0;
  // Once a step, at its start; see mechanism/maximal.hpp.
  virtual mechanism::Independence choose(Wide t_s, const Wide* y) = 0;
  [[nodiscard]] virtual Wide project(Wide t_s, Wide* y) = 0;
  virtual Sample sample(Wide t_s, const Wide* y) const = 0;
  virtual Wide stop_force(Wide t_s, const Wide* y, int joint) const = 0;
  virtual Wide acceleration(Wide t_s, const Wide* y, int joint) const = 0;
  virtual Wide impact(Wide t_s, Wide* y, int joint, Wide restitution) const = 0;
  virtual Wide response(Wide t_s, const Wide* y, int joint, int other) const = 0;
  // A joint's first coordinate and rate.
  virtual std::array<Wide, 2> coordinate(const Wide* y, int joint) const = 0;
  // True: between the state given to choose() and y the chosen constraints lost rank, or the choice of coordinates that
  // depend on others has to change.
  virtual bool turned_over(Wide, const Wide*) const { return false; }
  // The time in which no angle that poses give turns by more than 2 rad at its present rate; 0: no limit.
  virtual Wide longest_step(const Wide* y) const = 0;
  // Largest distance of a rope's ends from the planes of their pulleys [m].
  virtual Wide off_plane(const Wide* y) const = 0;
  virtual mechanism::RopeMargins<Wide> rope_margins(const Wide* y, int rope) const = 0;
};

// Of the steps: an instant that must be located more closely than long double resolves needs quad.
enum class Arithmetic { quad, long_double };

// Coordinates of the spanning tree by extrapolation; maximal coordinates by collocation. `start`: see
// mechanism/reduced.hpp; for maximal coordinates the poses and velocities of all bodies.
std::unique_ptr<MechanismMotion> reduced_motion(const Scene& scene, double t_end_s, const Sample& start,
                                                Arithmetic arithmetic = Arithmetic::quad);
std::unique_ptr<MechanismMotion> maximal_motion(const Scene& scene, double t_end_s, const Sample& start);

}  // namespace atwood::extended
