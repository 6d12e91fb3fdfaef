// Mechanisms in maximal coordinates: every mobile body has its pose and velocity, and the constraints are held by
// multipliers (Newton and Euler; index 1):
//   M a = f + G^T m,   G a + gamma = 0   =>   (G M^-1 G^T) m = -(G M^-1 f + gamma)
// The rows of the tree's joints, leaves first, are always independent; of the others (closing joints, ropes, stops) a
// largest independent set is chosen at each step, in quad, and kept during the step.
#pragma once

#include "dynamics/rates.hpp"
#include "mechanism/cholesky.hpp"
#include "mechanism/model.hpp"

namespace atwood::mechanism {

// What stays as it is during one step.
struct StepChoice {
  std::vector<int> chosen;  // among the rows that are not of the tree
  Memory memory;
  struct Lock {
    int joint;
    double coordinate;
  };
  std::vector<Lock> locks;  // joints at rest at a stop
  int interval = 0;         // between switches
  double interval_s = 0;    // an instant inside it
};

// How independent the chosen rows are: the smallest and the largest left out of the scaled pivots (squared sines).
struct Independence {
  double smallest = 1, dropped = 0;
  int rank = 0;
};

template <class S> class Maximal {
 public:
  // y: as dynamics::layout of the scene, then (s, s') of each rope with inertia. `start` holds the lengths of ropes.
  Maximal(const Scene& scene, double t_end_s, const Sample& start);

  int size() const { return size_; }
  const Model<S>& model() const { return model_; }
  const dynamics::Dynamics<S>& equations() const { return free_; }
  std::vector<S> initial(const Sample& start) const;
  std::vector<Motion<S>> motions(const S* y) const;

  StepChoice choice;
  // Chooses the rows and remembers branches at (t, y).
  Independence choose(const S& t_s, const S* y);
  void rate(const S& t_s, const S* y, S* dydt) const;
  // Moves y back onto the constraints and their derivatives, along M^-1 G^T (mass metric), by Newton's method while
  // each of at most 8 rounds divides the residual by ten. Returns the largest residual that is left, of all
  // constraints, chosen or not, in m or rad: the caller judges it.
  [[nodiscard]] S project(const S& t_s, S* y) const;
  // Poses, coordinates, reactions, tensions. not_unique is filled.
  Sample sample(const S& t_s, const S* y) const;
  // The force of a locked joint's stop along its coordinate.
  S stop_force(const S& t_s, const S* y, int joint) const;
  S acceleration(const S& t_s, const S* y, int joint) const;  // of a joint's first coordinate
  // Changes the velocities by the impulse p along joint's coordinate that multiplies its rate by -restitution; returns
  // p.
  S impact(const S& t_s, S* y, int joint, const S& restitution) const;
  // The rate of joint `other` that a unit impulse along `joint` makes.
  S response(const S& t_s, const S* y, int joint, int other) const;

 private:
  struct Solved;
  struct System;
  std::vector<Row<S>> rows_of_tree(const S& t_s, const std::vector<Motion<S>>& now) const;
  std::vector<Row<S>> other_rows(const S& t_s, const S* y, const std::vector<Motion<S>>& now) const;
  Row<S> locked_row(const typename StepChoice::Lock& lock, const std::vector<Motion<S>>& now) const;
  System make_system(const S& t_s, const S* y, const std::vector<Motion<S>>& now, bool all) const;
  Solved solve(const S& t_s, const S* y) const;
  void mark_not_unique(const S& t_s, const S* y, const std::vector<Motion<S>>& now, Sample& sample) const;
  void move(S* y, const std::vector<Acceleration<S>>& by, const std::vector<S>& rope_by, bool velocities) const;

  Model<S> model_;
  dynamics::Dynamics<S> free_;
  std::vector<int> rope_slot_;  // of s in y, or -1
  int size_ = 0;
};

extern template class Maximal<double>;
extern template class Maximal<Wide>;

}  // namespace atwood::mechanism
