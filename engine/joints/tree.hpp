// Mechanisms without closed loops, in the coordinates of their joints: kinematics and dynamics by the articulated-body
// algorithm (Featherstone, Int. J. Robotics Research 2 (1983) 13; Rigid Body Dynamics Algorithms (2008), chapter 7).
//
// A link is a moving body of the scene. Its pose follows from its parent's by its joint; a link without a joint is free
// and has six rates (a point mass: three). In a scene with joints or ropes every moving body is a link, so that
// constraints can tie any two of them. Links stand in an order in which parents come first.
//
// Everything is in world axes. A link's reference point A is the material point of its body at its joint's anchor; of a
// free body, the centre of mass. With r = centre of mass - A and J the inertia about A, Newton's and Euler's equations
// are
//   n = J alpha + m r x a + w x (J w)          moment about A
//   f = m (a + alpha x r + w x (w x r))        force
// with the body's angular acceleration alpha and the acceleration a of its point A. A joint adds, to the acceleration
// of its parent, the bias c of the motion at constant rates, and s_k u_k' for each of its rates: s_k is an axis, about
// which the child turns ("angular") or along which it moves. Eliminating the rates one by one, the outermost first,
//   U = I s,  D = s^T U,  I <- I - U U^T / D,  p <- p + U (tau - s^T p) / D
// leaves the inertia I and the bias force p that the parent feels. All rates of a link, also those of a free one, are
// eliminated in this way; the products are those of a Cholesky factorisation of the mass matrix.
//
// Generalised vectors ("rates": velocities, forces, accelerations) have rate_count() components, the links' one after
// another in the order of the links: of a joint its rates u; of a free body v_WB(3) and w_WB_B(3).
#pragma once

#include <string>
#include <vector>

#include "forces/force.hpp"
#include "joints/joint_forces.hpp"
#include "math/mat3.hpp"
#include "scene/scene.hpp"

namespace atwood {

// What does not change: how a link is attached to its parent, its mass, and where its coordinates are in the state.
template <class S> struct Link {
  int body = 0;        // index into Scene::bodies
  int parent = -1;     // a link; -1: free, or its joint ties it to something that does not move
  int joint = -1;      // index into Scene::joints; -1: a free body
  int root_body = -1;  // parent == -1: the fixed body that the joint ties it to; -1: the world
  JointKind kind = JointKind::fixed;
  bool rotates = true;            // false: a free point mass
  bool driven = false;            // its motion is prescribed: coordinate = start + t rate
  int at_q = 0, at_u = 0;         // in the state, of a joint's first coordinate and rate; of a free body: at_q = p_WB
  int first_rate = 0, rates = 0;  // in generalised vectors
  S mass_kg{};
  Vec3<S> from_parent_P;      // from the parent's reference point to the parent's anchor, parent's body axes
  Vec3<S> to_centre_B;        // r in body axes
  Sym3<S> J_B;                // inertia about A, body axes
  Vec3<S> axis_B, axis_P;     // axis_P: the first axis of a universal joint, in the parent's body axes
  Quat<S> frame, frame_axis;  // F, and F (0, axis): F exp(axis q) = cos(q/2) F + sin(q/2) F (0, axis)
  S driven_start{}, driven_rate{};
};

// The motion of a link at the last kinematics().
template <class S> struct LinkMotion {
  Quat<S> q_WB;
  Mat3<S> R_WB;
  Vec3<S> A, r, d;   // A; centre of mass - A; A - the parent's A (0 where there is no parent link)
  Vec3<S> w, v;      // angular velocity; velocity of the point A
  Vec3<S> c_n, c_f;  // bias c: of alpha, and of a
  Vec3<S> alpha, a;  // after accelerations() or accelerate_bodies()
  Vec3<S> n, f;      // after reactions(): the whole wrench on the link at its joint, about A
};

// One rate of a link: its axis, and what its elimination leaves for the way back.
template <class S> struct Column {
  Vec3<S> s;
  bool angular = true;
  Vec3<S> U_n, U_f;
  S inverse_D{}, force{};  // force: tau - s^T p
};

// An articulated inertia about a point (J moments, H coupling, M mass) and the bias wrench (n, f):
//   moment = J alpha   + H a + n
//   force  = H^T alpha + M a + f
template <class S> struct Articulated {
  Sym3<S> J;
  Mat3<S> H;
  Sym3<S> M;
  Vec3<S> n, f;
};

// The coordinate of a joint whose motion is prescribed: start + t rate, or that in the state.
enum class DrivenJoints { from_time, from_state };

template <class S> class Tree {
 public:
  // `offsets`: of each body's p_WB in the state, -1 where it is not in the state. The joints' coordinates and rates
  // stand in the state from `first_free` on, in the order of Scene::joints (joints that close loops have none): first
  // the coordinates that are integrated from their own rates, then those rates, then quaternion and rates of each ball.
  Tree(const Scene& scene, const std::vector<int>& offsets, int first_free);

  // Why the scene's joints cannot be simulated ("" if they can).
  const std::string& refusal() const { return refusal_; }

  // ---- layout
  int state_end() const { return state_end_; }
  // From a coordinate to its rate in the state, balls apart.
  int scalar_count() const { return scalar_count_; }
  int scalars_at() const { return scalars_at_; }  // where they begin
  int rate_count() const { return static_cast<int>(state_of_rate_.size()); }
  const std::vector<Link<S>>& links() const { return links_; }
  int link_of(int body) const { return link_of_body_[body]; }  // -1: the body does not move
  int joint_count() const { return static_cast<int>(link_of_joint_.size()); }
  int link_of_joint(int joint) const { return link_of_joint_[joint]; }  // -1: the joint closes a loop
  int state_of_rate(int k) const { return state_of_rate_[k]; }          // where a rate stands in the state
  // Of what a link without a parent is attached to: a fixed body, or the world.
  Quat<S> root_attitude(int link) const {
    return links_[link].root_body < 0 ? Quat<S>{} : resting_[links_[link].root_body].q_WB;
  }
  void initial_state(S* y) const;  // the joints' part
  // A free body that is held does not move: its rates are no unknowns then.
  void set_held(int body, bool held);

  // ---- kinematics at (t, y); every function below refers to its last call
  void kinematics(S t_s, const S* y, DrivenJoints driven = DrivenJoints::from_time);
  const LinkMotion<S>& motion(int link) const { return motion_[link]; }
  const Column<S>& column(int rate) const { return columns_[rate]; }
  Vec3<S> centre_W(int link) const { return motion_[link].A + motion_[link].r; }
  // Of a material point of a body, at x in the world (0 for bodies that do not move).
  Vec3<S> velocity_W(int body, const Vec3<S>& x_W) const;
  Vec3<S> angular_velocity_W(int body) const;
  // p v q w of a link's body in the layout of a rotating body's state (kBodyScalars).
  void write_body(int link, S* to) const;

  // ---- dynamics. `loads`: one per body, external forces; `applied`: generalised forces besides (rate_count(), null:
  // none). du: u' of all rates; leaves the bodies' accelerations.
  void accelerations(const Load<S>* loads, const S* applied, S* du);
  // du = M^-1 force, after accelerations() at this state. Rates of driven joints and held bodies stay 0.
  void solve(const S* force, S* du);
  // Adds to `generalised` what a force at x and a torque on a body amount to: J^T (force, torque). With unit vectors it
  // is the Jacobian's row of the velocity of the point x along the force (or of the angular velocity along the torque).
  void add_wrench(int body, const Vec3<S>& x_W, const Vec3<S>& force_W, const Vec3<S>& torque_W, S* generalised) const;
  // Accelerations of all bodies for given u'. With u' = 0: the bias accelerations J' u.
  void accelerate_bodies(const S* du);
  // Of a material point at x, and angular, after accelerations() or accelerate_bodies() (0 for bodies that do not
  // move).
  Vec3<S> acceleration_W(int body, const Vec3<S>& x_W) const;
  Vec3<S> angular_acceleration_W(int body) const;

  // ---- reactions, after the bodies' final accelerations are known
  // The wrench that each link's joint exerts on it, at A (LinkMotion::n, f); `loads` as above, `wrenches` (one a link,
  // null: none) of constraints that are no tree joints: force, and moment about the link's A.
  struct JointWrench {
    Vec3<S> force_W, moment_W;
  };
  void reactions(const Load<S>* loads, const JointWrench* wrenches);
  // Its part that does no work: without what acts along the free directions of the joint. Of a driven joint everything
  // but the forces `applied` along its coordinate.
  JointWrench constraint_wrench(int link, const S* applied) const;

 private:
  void order_links(const Scene& scene, const std::vector<int>& offsets);
  void lay_out(const Scene& scene, int first_free);
  void set_joint(const Scene& scene, const Joint& joint, Link<S>& link);
  void move_link(S t_s, const S* y, DrivenJoints driven, int i);
  void start_link(int i, const Load<S>* loads);
  void eliminate_link(int i, const S* applied);
  void add_to_parent(int i);
  void accelerate_link(int i, S* du);

  std::string refusal_;
  std::vector<Link<S>> links_;
  std::vector<LinkMotion<S>> motion_;
  std::vector<Column<S>> columns_;
  std::vector<Articulated<S>> articulated_;
  struct Twist {
    Vec3<S> angular, linear;
  };
  std::vector<Twist> response_;  // of solve()
  std::vector<int> link_of_body_, link_of_joint_, state_of_rate_;
  std::vector<char> held_;  // by link
  struct Start {
    int at;
    S value;
  };
  std::vector<Start> start_;
  struct RestingPose {
    Vec3<S> p_WB;
    Quat<S> q_WB;
  };
  std::vector<RestingPose> resting_;  // by body
  int state_end_ = 0, scalars_at_ = 0, scalar_count_ = 0;
};

}  // namespace atwood
