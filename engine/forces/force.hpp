// A force: a term that reads the motion of the bodies and adds to their loads.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "math/quat.hpp"
#include "math/vector_width.hpp"
#include "scene/scene.hpp"

namespace atwood {

class Team;

// Where a body's scalars (13, or 6 of a point mass) are stored: in the state, or in a separate array if it is fixed,
// held or placed by a joint.
template <class S> struct Slot {
  int offset = -1;  // of p_WB in the state; -1: not there
  bool rotates = false;
  bool on_joint = false;       // placed by a joint: its motion at present is in `resting`
  const S* resting = nullptr;  // not null: p v q w are here, and unless on_joint the body does not move at present
  bool moves() const { return resting == nullptr || on_joint; }
};

template <class S> struct Motion {
  S t_s;
  const S* y;
  const Slot<S>* slots;

  const S* of(int body) const { return slots[body].resting ? slots[body].resting : y + slots[body].offset; }
  Vec3<S> p_WB(int body) const { return load3(of(body)); }
  Vec3<S> v_WB(int body) const { return load3(of(body) + 3); }
  Quat<S> q_WB(int body) const { return slots[body].rotates ? load4(of(body) + 6) : Quat<S>{}; }
  Vec3<S> w_WB_B(int body) const { return slots[body].rotates ? load3(of(body) + 10) : Vec3<S>{}; }
};

template <class S> struct Load {
  Vec3<S> acceleration_W;  // of forces proportional to mass: never multiplied and divided by it
  Vec3<S> force_W;         // through the centre of mass
  Vec3<S> torque_B;        // about the centre of mass, body axes
};

// The motion in `count` states, one state per lane: scalar i of lane k is y[i * stride + k]. Fixed and held bodies
// stand in `resting`.
template <class S> struct LaneMotion {
  VectorWidth width;
  int count;
  const S* t_s;  // one per lane
  const S* y;
  std::ptrdiff_t stride;
  const Slot<S>* slots;
  const S* resting;        // of body i, scalar j, lane k: resting[(body_scalars i + j) 8 + k]
  const S* identity_pose;  // the same for a body at the origin with identity attitude, at rest
};
inline constexpr int kBodyScalars = 13, kLoadScalars = 9;

template <class S> class ForceTerm {
 public:
  virtual ~ForceTerm() = default;
  virtual void add_loads(const Motion<S>& motion, Load<S>* loads) const = 0;  // loads: one per body
  // The same for several states, with the same bits in every lane. Component c (acceleration, force, torque: 9) of body
  // i in lane k: loads[(9 i + c) 8 + k].
  virtual bool has_lanes() const { return false; }
  virtual void add_lane_loads(const LaneMotion<S>&, S* /*loads*/) const {}
  virtual bool velocity_dependent() const { return false; }
  // True: the only dependence on velocity is charge v x field with fixed fields; charge times field [C T] is added to
  // `charge_field_W` (one per body). False, with nothing added: velocities act in another way too.
  virtual bool add_magnetic(Vec3<S>* charge_field_W) const {
    (void)charge_field_W;
    return !velocity_dependent();
  }
  std::vector<Interval> on_s;  // empty: always
};

// Each force has a file. A factory throws Unsupported, with the reason, for a law that the engine does not have.
struct Unsupported {
  std::string reason;
};

// The sum of mutual gravity: over all pairs, or by a tree with multipoles (gravity_tree.hpp).
struct GravityOptions {
  enum class Sum { automatic, direct, tree } sum = Sum::automatic;  // automatic: direct up to kDirectBodies
  double opening = 0.5;                                             // of the tree
  Team* team = nullptr;                                             // null: one thread
};
inline constexpr int kDirectBodies = 10000;

template <class S> using TermPointer = std::unique_ptr<ForceTerm<S>>;
template <class S> TermPointer<S> make_term(const MutualGravity&, const Scene&, const GravityOptions&);
template <class S> TermPointer<S> make_term(const Attractor&, const Scene&);
template <class S> TermPointer<S> make_term(const LinearDrag&, const Scene&);
template <class S> TermPointer<S> make_term(const QuadraticDrag&, const Scene&);
template <class S> TermPointer<S> make_term(const Spring&, const Scene&);
template <class S> TermPointer<S> make_term(const Drive&, const Scene&);
template <class S> TermPointer<S> make_term(const Lorentz&, const Scene&);
template <class S> TermPointer<S> make_term(const Coulomb&, const Scene&);
template <class S> TermPointer<S> make_term(const Thruster&, const Scene&);
template <class S> TermPointer<S> make_term(const PointForce&, const Scene&);
template <class S> TermPointer<S> make_term(const RotatingFrame&, const Scene&);
template <class S> TermPointer<S> make_term(const Potential&, const Scene&);

}  // namespace atwood
