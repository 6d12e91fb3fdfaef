// Further constraints on the links of a tree: joints that close loops, ropes, coordinates that rest at a stop.
//
// The tree's articulated-body algorithm factors the mass matrix, M^-1 = W^T W with W generalised force -> "whitened"
// vector of one component a rate (column k of tree.hpp: force_k / sqrt(D_k)). With the rows G u' = b of the constraints
// and the free acceleration u'_0, Gauss's principle of least constraint asks for the smallest M-norm of u' - u'_0:
//   u' = u'_0 + W^T z
//   (W G^T)^T z = b - G u'_0,  z of least norm
// found by QR of W G^T with column pivoting (least_norm.hpp), whose R also gives the multipliers. Neither G M^-1 G^T
// nor its condition, the square, appears: a linkage passes its flat configuration with the pivots that are left.
//
// Rows. On a closed mechanism some rows may depend on the others in every configuration (a linkage in a plane;
// Bricard's). Off the constraints, at the stages of a step, the dependence is only approximate: those rows would act as
// additional constraints. So rows are chosen on the constraints, where their rank is known: at the start, there and at
// configurations beside it, and again after every projection, which may add rows and never removes one. A row that is
// not chosen must be satisfied by itself; a run in which it is not ends.
//
// Projection, after a step: of positions onto g(q) = 0, then of rates onto G u = 0, both along M^-1 G^T (the metric is
// the mass matrix). Positions by Newton's method until no value exceeds 16 roundings of the lengths in it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "joints/constraint.hpp"
#include "joints/least_norm.hpp"
#include "joints/rope.hpp"
#include "joints/tree.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

// Limits of a joint of the tree (scene/joint.hpp).
template <class S> struct JointStop {
  std::string name;
  int joint = 0, parent = -1, child = 0;
  int link = 0, rate = 0;  // rate: in generalised vectors
  int q_at = 0, u_at = 0;  // in the state
  S lower{}, upper{}, restitution{};
};

// A row that acts, on bodies of the scene.
template <class S> struct BodyRow {
  int body[2];  // -1: does not move
  Wrench<S> on[2];
  S value{}, tolerance{};
};

template <class S> class PlanarLoops;

template <class S> class Constraints {
 public:
  // `tree` outlives the constraints.
  Constraints(const Scene& scene, Tree<S>& tree);
  ~Constraints();

  // Why the scene's constraints cannot be simulated ("" if they can).
  const std::string& refusal() const { return refusal_; }
  bool empty() const { return rows_.empty(); }

  // Takes the ropes' lengths from the state y at t = 0 and chooses the rows. Here and below joints whose motion is
  // prescribed are where y has them. Changes the tree's kinematics.
  void start(const S* y);

  // The same constraints where the tree moves in planes and its loops are closed by hinges across them; null elsewhere.
  PlanarLoops<S>* planar() { return planar_.get(); }
  // Records the least pivot of rates computed by planar().
  void record_pivot(S least) { least_pivot_ = real::min(least_pivot_, least); }

  // After tree.accelerations() at this state: changes du, the free accelerations, to those under the constraints.
  // Bodies' accelerations stay those of the tree alone.
  void constrain(S* du);
  // Of the last constrain(): the wrench of all constraints on each link, about its point A; one entry a link.
  const typename Tree<S>::JointWrench* wrenches();

  // Positions and rates in y onto the constraints. False: not found; fault() says why.
  bool project(S* y);
  const std::string& fault() const { return fault_; }
  const SolveReport& report() const { return report_; }  // of the last project()

  // ---- symmetric projection (integrators/symmetric_projection.hpp); one entry a row
  struct Multipliers {
    std::vector<S> position, rate;
  };
  Multipliers no_multipliers() const { return {std::vector<S>(rows_.size()), std::vector<S>(rows_.size())}; }
  // Moves y by M^-1 G^T times the multipliers, coordinates and rates, with M and G those at `at`.
  void displace(const S* at, const Multipliers& by, S* y);
  // Adds to `by` half of what would take y onto the constraints along M^-1 G^T. Returns how far y is from them, in 16
  // roundings of the lengths in a constraint and of the speed, at least `speed`.
  S add_half_correction(const S* y, Multipliers& by, S speed);
  // The root of twice the kinetic energy, or more, at the last kinematics.
  S speed_scale() const;

  // Of the last constrain()
  S tension(int rope) const;
  // The wrench of a closing joint on its child at its anchor, and which of its components (bits 0 to 2 the force, 3 to
  // 5 the torque, world axes) the constraints do not determine.
  typename Tree<S>::JointWrench closing_wrench(int joint) const;
  // The same components, of any joint.
  unsigned not_unique(int joint) const { return open_components_[joint]; }
  void find_open_components();  // at the present kinematics and factors

  // Of all constrain() since reset_pivots(): smallest relative pivot; 1: the row is independent of the others. Near a
  // singular configuration it is proportional to the distance from there.
  S least_pivot() const { return least_pivot_; }
  void reset_pivots() { least_pivot_ = S(1); }
  // The largest least pivot of a constrain() since start() or restart().
  S typical_pivot() const { return typical_pivot_; }
  void restart() { fault_.clear(), typical_pivot_ = S(0); }

  // The chosen rows at y; ropes with heavy pulleys and coordinates at stops are left out.
  void rows_at(const S* y, std::vector<BodyRow<S>>& rows);

  // ---- coordinates at their limits; a locked one does not change (hinge, slider of the tree)
  const std::vector<JointStop<S>>& stops() const { return stops_; }
  void lock(int joint, bool locked, S at = S(0));  // at: the coordinate, which projections set
  S locked_force(int joint) const;                 // of the last constrain(): along the coordinate; 0: not locked
  // Change of the rates when the coordinate's rate of each listed joint changes by `change`: M^-1-weighted, under the
  // constraints and the coordinates that are locked; impulse: along the coordinates.
  void impact_at_limits(const S* y, const std::vector<int>& joints, const std::vector<S>& change, S* du, S* impulse);

  // The coordinates of a closing joint at the present kinematics (constraint.hpp)
  void closing_coordinates(const Joint& joint, S* q, S* u) const;
  const RopeConstraint<S>& rope(int i) const { return ropes_[i]; }
  RopePath<S> rope_path_of(int rope) const;  // at the present kinematics

 private:
  struct Row {
    JointRow<S> row;
    int joint = -1, rope = -1;  // index into joints_ or ropes_; both -1: coordinate
    int part = 0;               // which condition
    int rate = -1;              // of a locked coordinate, in generalised vectors
    int link[2] = {-1, -1};
    int group = 0, extra = -1;  // extra: unknown of the group besides the rates, with coefficient -1
    S scale = S(1);             // of its column, a priori
    S tolerance = S(0);         // of its value
    bool chosen = false, locked = false;
    S locked_at{}, multiplier{};
    std::vector<int> path;  // links from both ends to the roots, outermost first
  };
  struct Group {
    std::vector<int> links, rates, rows;  // ascending
    std::vector<S> extra_kg;
    std::vector<int> used;  // rows of the last factorisation
    LeastNorm<S> qr;
    int size() const { return static_cast<int>(rates.size() + extra_kg.size()); }
  };
  struct Twist {
    Vec3<S> angular, linear;
  };

  void build_rows(const Scene& scene);
  void build_groups();
  TiedBody<S> body_motion(int body) const;
  bool evaluate();  // all rows at the present kinematics; false: a rope has no path
  void whiten(const Row& row, S* column);
  void unwhiten(const Group& group, const S* z, S* du);
  void factor(Group& group, bool all, S tolerance);
  void compute_inverse_sqrt_D();
  S row_rate(const Row& row, const S* rates) const;
  S row_acceleration(const Row& row, const S* du) const;
  void refactor(const S* y);
  void solve(Group& group, const std::vector<S>& b, S* du);
  void apply_change(const Group& group, const S* change, S* y) const;
  bool project_positions(S* y);
  void project_rates(S* y);
  void missing_rates(const Group& group);
  void set_locked(S* y) const;
  bool add_rows(const S* y);
  void choose_rows_nearby(const S* y);
  S worst_value(bool chosen_alone) const;
  void mark_open_components(int links);
  friend class PlanarLoops<S>;

  std::string refusal_, fault_;
  Tree<S>& tree_;
  std::unique_ptr<PlanarLoops<S>> planar_;
  std::vector<JointConstraint<S>> joints_;
  std::vector<int> scene_joint_;       // of joints_
  std::vector<int> closing_of_joint_;  // by scene joint; -1
  std::vector<RopeConstraint<S>> ropes_;
  std::vector<Row> rows_;
  std::vector<Group> groups_;
  std::vector<int> local_;  // of a rate in its group
  std::vector<TiedBody<S>> resting_;
  std::vector<int> locked_row_;    // by scene joint; -1
  std::vector<Twist> twist_;       // by link
  std::vector<S> inverse_sqrt_D_;  // 1 / sqrt(D), by rate
  std::vector<S> b_, z_, x_, change_, trial_, scratch_;
  std::vector<Load<S>> no_loads_;
  std::vector<typename Tree<S>::JointWrench> wrenches_;
  std::vector<unsigned> open_components_;
  SolveReport report_;
  std::vector<JointStop<S>> stops_;
  S least_pivot_ = S(1), typical_pivot_{};
  S size_m_{};
};

}  // namespace atwood
