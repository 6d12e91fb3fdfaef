// Mechanisms in the coordinates of a spanning tree: M(q) u' = tau, with M from the composite inertias of the subtrees
// and the joints' axes in world axes (Walker and Orin 1982), and multipliers for what the tree leaves open (closing
// joints, ropes):
//   M u' = tau + G^T m,   G u' + gamma = 0
#pragma once

#include "dynamics/rates.hpp"
#include "mechanism/cholesky.hpp"
#include "mechanism/maximal.hpp"

namespace atwood::mechanism {

template <class S> class Reduced {
 public:
  // y = (p, q of each body that no joint places and that is mobile; coordinates of the tree's joints; s of each rope
  // with inertia; then v, w (body axes), rates, s' in the same order).
  Reduced(const Scene& scene, double t_end_s, const Sample& start);

  int size() const { return coordinates_ + rates_; }
  int rate_count() const { return rates_; }
  int coordinate_count() const { return coordinates_; }
  const Model<S>& model() const { return model_; }
  const dynamics::Dynamics<S>& equations() const { return free_; }
  // Groups of components of one kind, for error norms.
  const std::vector<int>& groups() const { return groups_; }
  // start: bodies and, for the tree's joints, coordinates and rates.
  std::vector<S> initial(const Sample& start) const;
  std::vector<Motion<S>> motions(const S* y) const;

  StepChoice choice;
  Independence choose(const S& t_s, const S* y);
  void rate(const S& t_s, const S* y, S* dydt) const;
  [[nodiscard]] S project(const S& t_s, S* y) const;
  Sample sample(const S& t_s, const S* y) const;
  S stop_force(const S& t_s, const S* y, int joint) const;
  S acceleration(const S& t_s, const S* y, int joint) const;  // of a joint's first coordinate
  S impact(const S& t_s, S* y, int joint, const S& restitution) const;
  S response(const S& t_s, const S* y, int joint, int other) const;
  // For solvers of the equations in implicit form. constrained(): the residuals and rate residuals of the chosen rows,
  // and their Jacobian G in the rates. imbalance(): M u' - tau - G^T m; of driven rates u' alone. multipliers(): those
  // that belong to rate().
  void constrained(const S& t_s, const S* y, std::vector<S>& residual, std::vector<S>& rate_residual,
                   std::vector<std::vector<S>>& G) const;
  std::vector<S> imbalance(const S& t_s, const S* y, const S* rates_rate, const S* multipliers) const;
  std::vector<S> multipliers(const S& t_s, const S* y) const { return solve(t_s, y).multipliers; }
  void coordinate_rates(const S* y, const S* u, S* dqdt) const;
  void remember_branches(const S* y) { remember(model_, motions(y), (choice = choice_at(y)).memory); }
  // The place of a joint's first coordinate and rate in y.
  int coordinate_slot(int joint) const { return joint_q_[joint]; }
  int rate_slot(int joint) const { return coordinates_ + joint_u_[joint]; }
  // Columns on which the chosen rows have their largest minors, and the sign of that determinant: it changes where the
  // constraints lose rank (or where other columns must be taken).
  std::vector<int> pivot_columns(const S& t_s, const S* y) const;
  int orientation(const S& t_s, const S* y, const std::vector<int>& columns) const;

 private:
  struct Dof {
    bool turns;
    Triple<S> s, o;  // axis; a point of the axis of a rotation
  };
  struct Tree {  // kinematics at one state
    std::vector<Motion<S>> now;
    std::vector<Dof> dofs;
  };
  struct Solved {
    Tree tree;
    std::vector<Row<S>> rows;
    std::vector<S> multipliers, u_rate;
    std::vector<Acceleration<S>> a, a_free;
  };
  Tree kinematics(const S* y) const;
  // Accelerations of all bodies for given rates of u (null: zero).
  std::vector<Acceleration<S>> accelerations(const Tree& tree, const S* y, const S* rates_rate) const;
  Envelope<S> mass_matrix(const Tree& tree) const;
  std::vector<S> pull_back(const Tree& tree, std::vector<Wrench<S>> loads) const;
  std::vector<S> pull_back(const Tree& tree, const Row<S>& row) const;
  std::vector<Row<S>> other_rows(const S& t_s, const S* y, const std::vector<Motion<S>>& now, bool all) const;
  void hold(Envelope<S>& M) const;
  Solved solve(const S& t_s, const S* y) const;
  std::vector<S> kick(const S& t_s, const S* y, int joint) const;
  bool is_held(int dof) const;
  StepChoice choice_at(const S* y) const;
  std::vector<Acceleration<S>> free_accelerations(const S& t_s, const std::vector<Motion<S>>& now) const;
  void displace(S* y, const std::vector<S>& change) const;
  std::vector<Wrench<S>> inertial_loads(const Solved& now) const;
  std::vector<S> full_state(const std::vector<Motion<S>>& now) const;
  std::vector<std::vector<S>> chosen_jacobian(const S& t_s, const S* y) const;

  Model<S> model_;
  dynamics::Dynamics<S> free_;
  int coordinates_ = 0, rates_ = 0;
  std::vector<int> body_q_, body_u_, joint_q_, joint_u_, rope_q_, rope_u_;  // -1: none; u within the rates
  std::vector<int> dof_begin_, dof_count_, parent_;                         // of each body
  std::vector<int> first_;                                                  // envelope of M
  std::vector<int> groups_;
  std::vector<char> driven_;
};

}  // namespace atwood::mechanism
