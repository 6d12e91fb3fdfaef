// The state of a run of "+impulse", as plain arrays: allocated once a run, grown where contacts grow.
//
// A step of length h_s is divided into `substeps` substeps of length sub_s (Macklin, Storey, Lu, Terdiman, Chentanez,
// Jeschke, Mueller, "Small Steps in Physics Simulation", SCA 2019; Catto, "Solver2D", 2024). Each substep:
//
//   impacts    fast approaches that meet within the substep are resolved one after another, in the order of their times
//              (impacts.cpp)
//   velocity   v += dv_free, the increment of the motion without contacts
//   prepare    position correction: overlap is reduced only in the positions, no velocity changes;
//              velocity bias:       gaps and normals at the new positions give the bound on the normal velocity;
//              warm start:          the impulses of the last substep are applied again
//   solve      v_n >= -max(gap, 0) / sub_s, impulses inside the round friction cone
//   position   p += sub_s v
//
// The order of the contacts depends only on the contacts (graph colouring, contact_batches.hpp), so the results have
// the same bits for every number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "collision/broad_phase.hpp"
#include "collision/contacts.hpp"
#include "collision/geometry.hpp"
#include "contact/stepping/contact_batches.hpp"
#include "contact/stepping/graph_colouring.hpp"
#include "contact/stepping/rows.hpp"
#include "contact/stepping_options.hpp"
#include "integrators/stepper.hpp"
#include "math/dense_lu.hpp"
#include "parallel/team.hpp"
#include "protocol/sample.hpp"
#include "rigid/model.hpp"

namespace atwood::stepping {

// ---- bodies: rows of eight scalars, SI units, world axes
//   velocity  vx vy vz  wx wy wz  1/m  1/I     1/I of bodies with an isotropic inertia, else 0
//   pose      px py pz  sx sy sz  .    .       s: rotation vector since the step began
//   inertia   I^-1: xx xy xz yy yz zz  1/m  .
// The velocity and inertia rows of a fixed or sleeping body are 0.
template <class S> struct BodyRows {
  int count = 0;  // row `count` is 0 throughout: the body of unused lanes
  std::vector<Row<S>> velocity, pose, inertia;
  std::vector<Quat<S>> q_WB;               // at the beginning of the step
  std::vector<Row<S>> velocity_increment;  // of the motion without contacts, in a substep
  std::vector<Row<S>> pose_increment;      // of that motion too: what the velocities do not account for
  std::vector<Row<S>> impact_shift;        // displacement that the impacts of a substep add to its motion
  std::vector<Row<S>> velocity_before;     // before the increment, where positions are advanced with the mean velocity
  std::vector<Row<S>> velocity_before_sweep;  // where sweeps go on until the velocities converge
  std::vector<unsigned char> moves;           // 1: neither fixed, held nor asleep
  std::vector<unsigned char> isotropic;       // 1: the inertia is a multiple of the identity
  std::vector<S> motion_bound;                // m; how far a surface point may move within the step
};

// ---- rolling.cpp: cylinders and capsules in lasting contact
template <class S> struct Rolling {
  bool has_round_bodies = false;                  // some moving body is a cylinder or a capsule
  std::vector<int> bodies, manifolds;             // those that roll in this step
  std::vector<unsigned char> rolls;               // by body: it rolled in the last step
  std::vector<Vec3<S>> rate_change_by_forces;     // by body, rad/s in a substep, world axes
  std::vector<Vec3<S>> acceleration_by_contacts;  // by body, rad/s^2, of the last substep
  std::vector<Vec3<S>> rate_after_forces;         // by body, rad/s: before contacts act
  std::vector<Vec3<S>> rotation_before_drift;     // by body: rotation vector since the step began
};

// ---- sleep.cpp: the arrays are empty unless the option is on
struct Sleep {
  std::vector<int> sleeping_island;    // of body i, named by one of its bodies; -1: awake
  std::vector<double> time_at_rest_s;  // of body i
  std::vector<int> parent;             // union-find over bodies
};

// Work arrays, kept from call to call only to keep their memory.
template <class S> struct Scratch {
  GraphColouring colouring;
  std::vector<int> count, next_slot, colour, other_colour;
  std::vector<StoredImpulse<S>> sphere_impulses, plane_impulses;
  std::vector<std::vector<ContactManifold<S>>> detected;    // by thread
  std::vector<std::vector<Manifold<S>>> pair_manifolds;     // by thread
  std::vector<std::vector<Manifold<S>>> manifolds_updated;  // by stale manifold
};

// ---- direct.cpp: one island's problem
template <class S> struct SolverPoint;  // contact_points.hpp

// A row of the contact Jacobian J, for a direction d at a contact point: the moments r x d about the two bodies'
// centres of mass, and the body rates I^-1 (r x d) that a unit impulse along d gives.
template <class S> struct JacobianRow { Vec3<S> direction, moment_a, moment_b, rate_a, rate_b; };

// What a unit impulse along a row does to a mechanism under its joints (mechanisms.hpp): a vector whose scalar products
// are entries of W. mechanism -1: none.
template <class S> struct TiedResponse {
  int mechanism = -1;
  std::vector<S> z;
};

template <class S> struct DirectSolver {
  std::vector<int> parent;                    // union-find over bodies
  std::vector<std::pair<int, int>> contacts;  // contact, island
  std::vector<int> inactive;             // contacts left out: without impulse, and too far to close in this substep
  std::vector<SolverPoint<S>> points;    // of the island
  std::vector<int> contact_of_point;     // negative: -1 - s for joint stop s, which has only a normal impulse
  std::vector<JacobianRow<S>> jacobian;  // three rows a point: n, t, s
  std::vector<TiedResponse<S>> tied;     // two a row: of the mechanisms of a and b; empty where the scene has no joints
  std::vector<int> mechanisms;           // that the rows act on
  // Delassus matrix W = J M^-1 J^T, free velocities q, impulses l, row steps r, z = l - r (W l + q), residual F,
  // Newton's step; *_try: of the line search
  std::vector<S> W, q, l, row_step, z, z_try, F, F_try, newton_step, l_try;
  DenseLu<S> lu{0};
  int n() const { return static_cast<int>(points.size()); }
  const S& w(int i, int j) const {
    return W[static_cast<std::size_t>(i) * (3 * points.size()) + static_cast<std::size_t>(j)];
  }
  S& w(int i, int j) { return W[static_cast<std::size_t>(i) * (3 * points.size()) + static_cast<std::size_t>(j)]; }
};

// ---- impacts.cpp
template <class S> struct PredictedTime {
  S t_s{};  // since the substep began
  int contact = 0;
};
template <class S> struct ImpactQueue {
  std::vector<int> with_restitution;           // contacts
  std::vector<int> first, of_body;             // those of body i: of_body[first[i]] .. of_body[first[i + 1]]
  std::vector<PredictedTime<S>> queue;         // a heap, the earliest on top
  std::vector<PredictedTime<S>> simultaneous;  // put back into the queue, where the scene asks for one after another
  std::vector<Manifold<S>> manifolds;          // work array
};

// ---- contact_report.cpp
// A contact's impulses on b, summed over a step. The normal may turn within the step; friction stays inside its cone:
// |tangential_W| <= mu normal_N_s.
template <class S> struct ImpulseSum {
  S normal_N_s{};                  // sum of the normal impulses' sizes
  Vec3<S> normal_W, tangential_W;  // vector sums, N s
};

// The normal velocity of a contact without restitution when the step began.
template <class S> struct ApproachSpeed {
  int contact = 0;
  S vn_m_per_s{};
};

template <class S> struct TiedBodies;  // mechanisms.hpp

// ---- candidate_pairs.cpp: pairs of bodies that may touch, valid until a body has left its margin
template <class S> struct Candidates {
  bool valid = false;
  std::vector<CandidatePair> sphere_pairs, plane_pairs, manifold_pairs;
  bool has_fixed_pairs = false;  // body b of some pair of the broad phase is fixed
  std::unique_ptr<BroadPhase<S>> broad_phase;
  std::vector<BroadItem<S>> items;
  std::vector<std::int32_t> item_body;
  std::vector<BodyPair> overlapping_pairs;
  std::vector<S> margin;                       // by body, m
  std::vector<Vec3<S>> position_at_detection;  // by body
  std::vector<S> rotation_path;                // by body, m: sum of how far surface points rotated since
};

// Why a run ends early; with these default values it continues.
template <class S> struct RunEnd {
  bool impacts_stalled = false;  // impacts at one instant found no end (impacts.cpp)
  S stall_time_s{};              // that instant
  int points_beyond_limit = 0;   // solver=direct: points of an island that is too large for it (direct.cpp)
};

// All that a run of `+impulse` works on.
//
//   part          holds                                     written by
//   (first part)  the scene and settings, fixed             run.cpp
//   the step      state, instants, lengths of steps         step.cpp, run.cpp
//   end           why the run ends before its time          impacts.cpp, direct.cpp
//   bodies        poses, velocities, increments, rows       step.cpp, the solvers (sphere_contacts.cpp,
//                                                           manifold_contacts.cpp, direct.cpp), impacts.cpp,
//                                                           mechanism_*.cpp, rolling.cpp, sleep.cpp
//   tied          mechanisms, their rows and factors        mechanisms.cpp, mechanism_*.cpp, direct.cpp
//   rolling       increments of bodies that roll            rolling.cpp
//   sleep         islands at rest                           sleep.cpp
//   candidates    candidate pairs and what they hold for    candidate_pairs.cpp; invalidated by run.cpp and sleep.cpp
//   narrow phase  manifolds of this step and the last       narrow_phase.cpp, rolling.cpp
//   contacts      contact batches by colour, impulses       candidate_pairs.cpp and narrow_phase.cpp fill them, the
//                                                           solvers write the impulses
//   impacts       queue of the substep's impacts            impacts.cpp
//   direct        the direct solver's matrices              direct.cpp
//   reports       impulse sums, approach speeds             contact_report.cpp, impacts.cpp, narrow_phase.cpp
//   scratch       work arrays without meaning between calls
template <class S> struct World {
  // ---- fixed for the run
  Options options;
  const Scene* scene = nullptr;
  RigidModel<S>* model = nullptr;
  Team* team = nullptr;  // null: one thread
  VectorWidth width = VectorWidth::narrow;
  std::vector<Geometry<S>> geometry;                // by body
  std::vector<std::int32_t> material;               // by body
  std::vector<PairCoefficients> pair_coefficients;  // of materials a, b at a * materials + b
  int materials = 0;
  bool has_restitution = false;  // some pair of materials has
  Vec3<S> gravity_W;
  Stepper<S>* stepper = nullptr;            // of the motion without contacts; null: symplectic Euler
  bool positions_by_mean_velocity = false;  // of those before and after the increment, instead of that after
  Profile* profile = nullptr;               // null: nothing is timed
  const Observer* observer = nullptr;       // null: nothing is reported

  // ---- the step
  std::vector<S> y, y_free;  // the state as the model lays it out, and where it is without contacts
  S t_s{};                   // beginning of the substep
  S h_s{}, sub_s{};          // a step, a substep
  S step_end_s{};
  int substeps = 1;
  bool records_impulses = false;  // impulses of this step are summed: it ends at a sample, or events are wanted
  RunEnd<S> end;

  BodyRows<S> bodies;
  bool has_pose_increment = false;      // some row of BodyRows::pose_increment is not 0
  std::unique_ptr<TiedBodies<S>> tied;  // null: the scene has no joints
  Rolling<S> rolling;
  Sleep sleep;

  Candidates<S> candidates;

  // ---- narrow phase
  std::vector<ContactManifold<S>> manifolds, manifolds_before;  // of this step, of the last one
  std::vector<int> fast_manifolds;                              // manifolds whose bodies may move far within the step
  std::vector<int> stale_manifolds;                             // those that have, and are detected again

  // ---- contacts
  ColouredBatches<SphereBatch<S>> sphere_contacts;
  ColouredBatches<ManifoldBatch<S>> manifold_contacts;
  ImpactQueue<S> impacts;
  DirectSolver<S> direct;
  std::vector<ImpulseSum<S>> impulse_sums;  // by contact
  std::vector<ApproachSpeed<S>> approach_speeds;
  Scratch<S> scratch;

  const PairCoefficients& coefficients(int a, int b) const {
    return pair_coefficients[static_cast<std::size_t>(material[a] * materials + material[b])];
  }
};

// What a substep does to its contacts before the velocity solve: three parts, independent of each other.

// Moves the bodies of an overlapping contact apart, in their positions alone, by `share` (0 to 1) of the overlap beyond
// the slop. 0: no correction.
template <class S> struct PositionCorrection { S share{}; };

// Sets the bias of u_n + bias >= 0 from the gap at the end of the substep: max(gap, 0) / sub_s, so that a contact may
// close its gap and no more. Overlap gives no bias.
template <class S> struct VelocityBias {
  S sub_s{};                             // length of the substep
  const Row<S>* impact_shift = nullptr;  // by body: what impacts add to the positions by then; null: nothing
};

// Whether the impulses of the last substep are the first guess of this one, and are applied before the solve.
enum class WarmStart : bool { off, on };

template <class S> struct Preparation {
  PositionCorrection<S> position_correction;
  VelocityBias<S> velocity_bias;
  WarmStart warm_start = WarmStart::on;
};

// f(first, last, width) over shares of the batches [first, last) of a colour; fewer than `min_batches` stay on the
// calling thread. Each thread gets several shares, so that one that loses its core delays the others by little.
template <class S, class F> void for_batches(World<S>& world, int first, int last, int min_batches, const F& f) {
  const auto work = [&](int from, int to) {
    in_lanes<S>(world.width, [&](auto width) ATWOOD_INLINED { f(from, to, width); });
  };
  const int count = last - first;
  if (world.team == nullptr || count < min_batches) return work(first, last);
  const int parts = std::min(4 * world.team->size(), 2 * count / min_batches);
  world.team->run(parts, [&](int part) {
    const Share own = share(count, part, parts);
    work(first + own.first, first + own.last);
  });
}

// f(first, last) over shares of the bodies.
template <class S, class F> void for_bodies(World<S>& world, const F& f) {
  const int count = world.bodies.count;
  if (world.team == nullptr || count < 1000) return f(0, count);
  world.team->run(true, [&](int part) {
    const Share own = share(count, part, world.team->size());
    f(own.first, own.last);
  });
}

// ---- step.cpp
// Sets all rows of all bodies from world.y, under the forces of the model's present interval.
template <class S> void load_bodies(World<S>& world);
// Sets the rows of one body.
template <class S> void load_body(World<S>& world, int body);
// Sets the velocity increments to gravity's, for a substep of another length.
template <class S> void set_gravity_increments(World<S>& world);
// Writes the moving bodies' states to world.y.
template <class S> void store_bodies(World<S>& world);
// Takes a step of h_s from t_s. False: the implicit equations of the motion without contacts were not solved.
template <class S> bool step(World<S>& world, S t_s, S h_s);
// R I^-1 R^T by the images of the world's axes, and 1/m.
template <class S> Row<S> inverse_inertia(const MassProperties<S>& mass, const Quat<S>& q_WB);

// ---- candidate_pairs.cpp
// Sets the pairs that may touch within the coming step of h_s and lays out the sphere contacts, unless the current
// pairs are still valid. Sets the bodies' motion bounds.
template <class S> void update_candidate_pairs(World<S>& world, S h_s);

// True: `body` has left its margin since detection, or will within remaining_s (an impact has made it faster), and may
// meet there a body with which it forms no candidate pair.
template <class S> bool may_miss_a_pair(const World<S>& world, int body, S remaining_s);

// ---- narrow_phase.cpp
// Once a step: detects the manifolds of all pairs, transfers the impulses of the last step, lays out the contacts.
template <class S> void find_manifolds(World<S>& world);
// Before a later substep: detects those again whose bodies have moved relative to each other, or roll.
template <class S> void update_stale_manifolds(World<S>& world);

// ---- sleep.cpp: a sleeping body is treated as fixed
// At the end of a step of h_s.
template <class S> void put_islands_to_sleep(World<S>& world, S h_s);
// Sets the rows of a body to those of a fixed one.
template <class S> void freeze_body(World<S>& world, int body);
// Wakes the islands that a moving body may touch within the step. True: there was one, and contacts are to be found
// again.
template <class S> bool wake_touched_islands(World<S>& world);
template <class S> void wake_all(World<S>& world);

// ---- impacts.cpp
// Lists the contacts with restitution, once contacts are found.
template <class S> void list_contacts_with_restitution(World<S>& world);
// Resolves the impacts of a substep: changes velocities and impact shifts.
template <class S> void resolve_impacts(World<S>& world);

// ---- rolling.cpp
// Lists what rolls in the coming step of h_s, once contacts are found and velocity increments are set.
template <class S> void list_rolling(World<S>& world, S h_s);
// Before a later substep's contacts are detected.
template <class S> void update_rolling_inertias(World<S>& world);
// Before the velocity increments are applied: sets those of the bodies that roll.
template <class S> void set_rolling_velocity_increments(World<S>& world);
// Once contacts are prepared: changes their biases, surface velocities and arms.
template <class S> void predict_rolling_contact_points(World<S>& world);
// After the positions are advanced.
template <class S> void compose_rolling_rotations(World<S>& world);

// ---- sphere_contacts.cpp, manifold_contacts.cpp
// Once a substep: gap, arms, position correction, velocity bias and warm start of every contact.
template <class S> void prepare_sphere_contacts(World<S>& world, const Preparation<S>& preparation);
template <class S> void prepare_manifold_contacts(World<S>& world, const Preparation<S>& preparation);
// One sweep of projected Gauss-Seidel (sequential impulses): changes velocities and impulses.
template <class S> void solve_sphere_contacts(World<S>& world);
template <class S> void solve_manifold_contacts(World<S>& world);
// Effective masses of all manifold contacts, of one batch.
template <class S> void update_effective_masses(World<S>& world);
template <class S> void update_effective_masses_of(World<S>& world, ManifoldBatch<S>& batch);

// ---- direct.cpp
// Solves all contacts island by island with Newton's method: changes velocities and impulses. False: there are too many
// points, and the sweeps are to solve them; with solver=direct `points_beyond_limit` is set. `at_rest`: nothing moves
// faster than gravity accelerates it in a substep.
template <class S> bool solve_directly(World<S>& world, bool at_rest);

// ---- contact_report.cpp: changes no motion
template <class S> void clear_impulse_sums(World<S>& world);
// After each substep.
template <class S> void add_impulses_to_sums(World<S>& world);
// Writes the contacts of the step of h_s that was taken to `sample`: mean forces, places, gaps.
template <class S> void report_contacts(const World<S>& world, S h_s, Sample& sample);
// At the beginning of a step: records the approach speeds of contacts without restitution that carry no force yet.
template <class S> void record_approach_speeds(World<S>& world);
// At its end: reports an impact for each of those that carries force now.
template <class S> void report_impacts(World<S>& world);

}  // namespace atwood::stepping
