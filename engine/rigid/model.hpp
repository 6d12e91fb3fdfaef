// The equations of motion of a scene: the layout of the state by body, and the rates.
//
// State: for each body that is not fixed, one after another,
//   p_WB(3) v_WB(3)                      a point mass
//   p_WB(3) v_WB(3) q_WB(4) w_WB_B(3)    a body that rotates
// A bare problem (lorenz) is three scalars. Mass, inertia, charge stay in the model. Bodies that joints place are not
// in the state; after the bodies stand the coordinates and rates of the joints (joints/tree.hpp).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "forces/conservative.hpp"
#include "forces/force.hpp"
#include "forces/series_forces.hpp"
#include "joints/tree.hpp"
#include "math/lanes.hpp"
#include "math/principal_axes.hpp"
#include "math/system.hpp"
#include "parallel/team.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood {

template <class S> struct BodyState {
  Vec3<S> p_WB, v_WB;
  Quat<S> q_WB;
  Vec3<S> w_WB_B;
};

// Offsets inside one body's part of the state.
inline constexpr int kAtPosition = 0, kAtVelocity = 3, kAtAttitude = 6, kAtBodyRate = 10;

template <class S> struct MassProperties {
  S mass_kg{}, inverse_mass_per_kg{};  // both 0: fixed (and its inverse inertia is 0 too)
  Vec3<S> I_row[3];                    // inertia about the centre of mass, body axes
  Vec3<S> I_inverse_row[3];
  bool diagonal = true;  // body axes are principal
  PrincipalAxes<S> principal;

  template <class V = S> ATWOOD_INLINE Vec3<V> times_inertia(const Vec3<V>& w_B) const { return times(I_row, w_B); }
  template <class V = S> ATWOOD_INLINE Vec3<V> times_inverse_inertia(const Vec3<V>& L_B) const {
    return times(I_inverse_row, L_B);
  }

 private:
  template <class V> ATWOOD_INLINE Vec3<V> times(const Vec3<S> (&row)[3], const Vec3<V>& v) const {
    if (diagonal) return {row[0].x * v.x, row[1].y * v.y, row[2].z * v.z};
    return {dot(row[0], v), dot(row[1], v), dot(row[2], v)};
  }
};

template <class S> class Constraints;
template <class S> class JointRates;

// How rates are computed. Results depend on `gravity.sum` and `gravity.opening` only.
struct ModelOptions {
  GravityOptions gravity;  // its team is the model's own
  int threads = 1;
  bool project_constraints = true;  // of loops and ropes, after each step
};

template <class S> class RigidModel {
 public:
  explicit RigidModel(const Scene& scene, const ModelOptions& options = {});
  ~RigidModel();
  RigidModel(const RigidModel&) = delete;
  RigidModel& operator=(const RigidModel&) = delete;

  // Why the engine cannot run this scene ("" if it can).
  const std::string& unsupported() const { return unsupported_; }
  bool bare_problem() const { return bare_problem_; }
  // Whether some force depends on velocities or body rates.
  bool velocity_dependent() const { return velocity_dependent_; }
  // The same of the forces alone: the accelerations of mechanisms always depend on rates.
  bool forces_depend_on_velocities() const { return forces_depend_on_velocities_; }
  // Whether forces depend on velocity, at all times, only by v' = ... + v x omega with a fixed omega for each body.
  bool magnetic_only() const { return magnetic_only_; }
  // The omega of magnetic_only() under the present force law [rad/s], one per body.
  void gyration(std::vector<Vec3<S>>& omega_W) const;

  // The scene's mechanisms; null: no body of the scene is tied to another.
  const Tree<S>* tree() const { return tree_.get(); }
  // Loops and ropes that tie its links further; null: none.
  Constraints<S>* constraints() { return constraints_.get(); }
  // Why the motion cannot go on from y at t_s, the end of a step ("": it can): constraints were not met, a rope is
  // slack.
  std::string constraint_fault(S t_s, const S* y);
  // Continues the angles of closing joints and of ropes at pulleys to y at t_s, the end of a step, so that any number
  // of turns may lie between two samples. Changes the tree's kinematics.
  void follow_turns(S t_s, const S* y);

  // Adds a force that the scene does not name; to be called before any stepper is made. `what` ("contact forces") names
  // it in the refusals of methods that need an energy or a series.
  void add_term(TermPointer<S> term, const std::string& what);

  // ---- layout
  int body_count() const { return static_cast<int>(slots_.size()); }
  int state_size() const { return state_size_; }
  int offset(int body) const { return slots_[body].offset; }  // -1: not in the state: fixed, or placed by a joint
  bool rotates(int body) const { return slots_[body].rotates; }
  const MassProperties<S>& mass(int body) const { return mass_[body]; }
  void initial_state(S* y) const;
  // Fixed ones included. Joints whose motion is prescribed are where y has them.
  BodyState<S> body(int body, const S* y) const;
  void set_body(int body, const BodyState<S>& state, S* y) const;  // no effect on a body that is not in the state
  void write(S t_s, const S* y, Sample& sample);                   // sample.bodies is resized once; t_s is not set

  // ---- switches and releases: select_interval sets the force law of [from_s, to_s], that at its midpoint
  const std::vector<double>& switch_times_s() const { return switch_times_s_; }  // sorted, unique, > 0
  void select_interval(S from_s, S to_s);                                        // cheap when nothing switches
  std::span<const int> moving() const { return moving_; }                        // of the state, not held at present
  // Where the state has quaternions that change at present, each with its rate in the frame that it turns: q' = 1/2 q
  // (0, w).
  struct Attitude {
    int q_at, w_at;
  };
  std::span<const Attitude> attitudes() const { return attitudes_; }
  // The other components that change at present.
  std::span<const int> plain_components() const { return plain_; }

  // ---- rates
  System<S>& system() { return system_; }  // y' = f(t, y) with embedded quaternions; lives as long as the model
  // The kick of partitioned methods: velocity entries get force / mass, body-rate entries I^-1 torque without the
  // gyroscopic term; every other entry is left as it is.
  void accelerations(S t_s, const S* y, S* dydt);
  void normalise(S* y) const;                            // unit quaternions
  bool feels_forces() const { return !terms_.empty(); }  // other than uniform gravity
  const Vec3<S>& uniform_gravity() const { return gravity_; }
  // Whether the force law of [from_s, to_s] is the present one, so that select_interval changes nothing.
  bool interval_selected(S from_s, S to_s) const { return interval_ >= 0 && interval_of(from_s, to_s) == interval_; }
  // Of the bodies that move now, where conservative().refusal() is "".
  const ConservativeForces<S>& conservative() const { return conservative_; }
  // All forces of the scene, also those that do not act now; empty for a scene without bodies.
  const SeriesForces<S>& series_forces() const { return series_forces_; }
  // Valid until the next one is asked for, or a rate.
  Motion<S> motion(S t_s, const S* y) const;
  S energy(const S* y) const;        // J, kinetic and potential
  S energy_scale(const S* y) const;  // J, the sum of absolute values: the scale of the energy's round-off
  // Of batches of rates; results have the same bits at each width.
  void set_vector_width(VectorWidth width) { width_ = width; }
  Team* team() const { return team_.get(); }  // null: one thread

 private:
  static void rate_of(void* context, S t_s, const S* y, S* dydt);
  static void rates_of(void* context, int count, const S* t_s, const S* y, S* dydt);  // rate_lanes.cpp
  static void project_of(void* context, S* y);
  static void projection_of(void* context, const S* y, S* change);
  int interval_of(S from_s, S to_s) const;
  void add_loads(S t_s, const S* y);
  // Those on joints, and all kinematics of the tree.
  void place_bodies(S t_s, const S* y, DrivenJoints driven = DrivenJoints::from_time) const;
  void apply_joint_forces(S t_s, const S* y);
  void accelerate_mechanisms(S t_s, const S* y);
  static void mechanism_rate_of(void* context, S t_s, const S* y, S* dydt);
  static void mechanism_rates_of(void* context, int count, const S* t_s, const S* y, S* dydt);
  void rate_of_links(S t_s, const S* y, S* dydt);  // by the tree and its constraints, whatever acts
  const S* at_driven_coordinates(S t_s, const S* y);
  void write_joints(S t_s, const S* y, Sample& sample);
  void write_constraints(S t_s, const S* y, Sample& sample);
  void follow_closing(std::size_t joint, S t_s);
  void build_joints(const Scene& scene);
  void build_constraints(const Scene& scene);
  void find_components();
  S kinetic_energy(const S* y) const;  // of bodies that have been placed
  S potential_energy(const S* y) const;
  void build_bodies(const Scene& scene);
  void build_forces(const Scene& scene, const GravityOptions& gravity);

  std::string unsupported_;
  std::unique_ptr<Team> team_;  // outlives the terms, which use it
  bool bare_problem_ = false, velocity_dependent_ = false, magnetic_only_ = true;
  int state_size_ = 0;
  std::vector<Slot<S>> slots_;
  std::vector<S> resting_;  // p, v = 0, q, w = 0 of every body: the motion of fixed and held ones
  std::vector<BodyState<S>> initial_;
  std::vector<double> release_s_;
  std::vector<MassProperties<S>> mass_;
  std::vector<Load<S>> loads_;
  std::unique_ptr<Tree<S>> tree_;
  std::unique_ptr<JointForces<S>> joint_forces_;
  std::unique_ptr<Constraints<S>> constraints_;
  friend class JointRates<S>;
  std::unique_ptr<JointRates<S>> joint_rates_;  // null: no joints
  bool project_constraints_ = true, forces_depend_on_velocities_ = false;
  std::vector<S> start_, projected_;   // of scenes with constraints: the state at t = 0; room for a state
  std::vector<Joint> closing_joints_;  // by scene joint; those of the tree are left empty
  std::vector<std::string> rope_names_;
  struct ClosingMotion {
    S t_s{};
    std::array<S, 4> q{};  // unwrapped
    std::array<S, 3> u{};
  };
  std::vector<ClosingMotion> closing_motions_;  // where follow_turns() or the last sample left them
  std::vector<S> rope_angle_;                   // of each rope's first straight part, unwrapped
  mutable std::vector<S> placed_;  // p v q w of bodies on joints, where they were placed last; one block a body
  std::vector<int> on_joints_;     // those bodies
  std::vector<S> applied_, du_;    // generalised vectors of the tree
  std::vector<Attitude> attitudes_;
  std::vector<int> plain_;
  std::vector<std::unique_ptr<ForceTerm<S>>> terms_;
  std::vector<const ForceTerm<S>*> active_;
  std::vector<double> switch_times_s_;
  std::vector<int> moving_;
  bool holds_ = false;  // some body of the state is held at present
  bool lanes_ = true;   // every active force has a law over lanes
  VectorWidth width_ = widest_vectors();
  LaneArray<S> resting_lanes_, load_lanes_;
  std::vector<S> one_;  // a state and its rate: used where batches are evaluated one state at a time
  int interval_ = -1;   // how many switch times have passed
  Vec3<S> gravity_;
  ConservativeForces<S> conservative_;
  SeriesForces<S> series_forces_;
  System<S> system_;
};

}  // namespace atwood
