// All that a step of "+impulse" works on, as plain arrays; allocated once a run, grown where contacts grow.
//
// A step of h is `substeps` substeps of h_s (Macklin, Storey, Lu, Terdiman, Mueller, Chentanez, "Small Steps in Physics
// Simulation", SCA 2019; Catto, "Solver2D", 2024), each of them
//
//   impacts    fast approaches that meet within the substep, one after another in the order of their times
//              (impacts.cpp)
//   kick       v += dv_free
//   prepare    overlap is pushed apart in the positions alone: no velocity ever sees it; gaps and normals at the new
//              positions; the impulses of the last substep are applied again (warm start)
//   solve      sweeps over all contacts:  v_n >= -max(gap, 0) / h_s,  impulse inside its round cone
//   drift      p += h_s v
//
// Contacts of a colour share no moving body, so they are solved eight at a time and by any number of threads; the order
// of the colours depends on the contacts alone, and so do the bits.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "collision/broad_phase.hpp"
#include "collision/contacts.hpp"
#include "collision/geometry.hpp"
#include "contact/stepping/colouring.hpp"
#include "contact/stepping/rows.hpp"
#include "contact/stepping_options.hpp"
#include "integrators/implicit_lu.hpp"
#include "integrators/stepper.hpp"
#include "parallel/team.hpp"
#include "protocol/sample.hpp"
#include "rigid/model.hpp"

namespace atwood::stepping {

// ---- rows of a body
//   velocity  vx vy vz  wx wy wz  1/m  1/I     world axes; 1/I of bodies whose inertia is a multiple of 1, else 0
//   place     px py pz  sx sy sz  .    .       s: turned by since the step began, a rotation vector
//   inertia   I^-1 in world axes: xx xy xz yy yz zz  1/m  .
template <class S> struct Bodies {
  int count = 0;  // row `count` is nobody's: all 0
  std::vector<Row<S>> velocity, place, inertia;
  std::vector<Quat<S>> q_WB;   // at the beginning of the step
  std::vector<Row<S>> kick;    // free flight's change of the velocity row in a substep
  std::vector<Row<S>> rest;    // ... and of the place row, beyond what the velocities give
  std::vector<Row<S>> shift;   // ... and what impacts within the substep add to it
  std::vector<Row<S>> before;  // velocities before the kick, where places go by the mean
  // ... and before the last sweep, where a scene at rest is swept until it is still
  std::vector<Row<S>> swept;
  std::vector<unsigned char> moves, isotropic;
  std::vector<S> reach;  // how far a surface point may get in a step
};

// ---- contacts of balls: with each other, with a fixed ball, with a plane
enum class Side : unsigned char { two_balls, fixed_ball, plane };

template <class S> struct BallBatch {
  std::int32_t a[kLaneCount], b[kLaneCount];
  std::int32_t count = 0;       // lanes in use; the others meet nobody with nobody
  bool active = false;          // some lane may touch in this substep
  Lanes<S> normal[3];           // unit, from a to b
  Lanes<S> radius_a, radius_b;  // of a plane: its offset along -normal, turned round
  Lanes<S> friction, restitution;
  Lanes<S> slop;            // overlap that is left alone
  Lanes<S> gap, closing;    // m; and over the substep, m/s: how fast it may close
  Lanes<S> arm_a, arm_b;    // from the centres to the point midway
  Lanes<S> mass_n, mass_t;  // 1 / mobility along the normal, across it
  Lanes<S> impulse_n, impulse_t[3];
};

// ---- contacts of all other shapes: a manifold a lane, up to four points
// What of a body's surface stays where it is when the body turns: all around a unit axis (cylinder, else 0), a ball of
// that radius about the body's centre or axis.
template <class T> struct Outline {
  Vec3<T> axis;
  T round_m;
};
template <class S> struct ManifoldPoint {
  Lanes<S> r_a[3], r_b[3];  // from the centres, world axes, when it was found
  Lanes<S> gap_found;       // gap = gap_found + n . D, D from the point moved with a to the point moved with b
  Lanes<S> gap, closing;
  Lanes<S> arm_a[3], arm_b[3];  // to the point midway between the surfaces
  Lanes<S> mass_n;
  Lanes<S> mass_t[3];  // inverse of the 2 x 2 mobility across the normal: 11 12 22
  Lanes<S> step_t;     // 1 / its larger eigenvalue
  Lanes<S> impulse_n, impulse_t[2];
};
template <class S> struct ManifoldBatch {
  std::int32_t a[kLaneCount], b[kLaneCount];
  std::int32_t manifold[kLaneCount];  // its number in `manifolds`
  std::int32_t count = 0, points = 0;
  bool active = false;
  Lanes<S> normal[3], tangent[3];  // unit, across each other; the second tangent is n x t
  Lanes<S> friction, restitution, slop;
  Lanes<S> axis_a[3], axis_b[3], round_a, round_b, lean;  // moved_point()
  Lanes<S> turned_a[3], turned_b[3];  // how far the bodies had turned since the step began when it was found
  ManifoldPoint<S> point[4];
  bool slips = false;   // some `slip` is not 0
  Lanes<S> slip[4][2];  // of a point: how much faster it slides half a substep later, m/s (rolling.cpp)
};

// Batches [first, last) that touch no moving body twice.
struct Colour {
  int first = 0, last = 0;
  Side side = Side::two_balls;
};

template <class Batch> struct Contacts {
  std::vector<Batch> batches;
  std::vector<Colour> colours;
  void clear() {
    batches.clear();
    colours.clear();
  }
};

// A pair that the broad phase let through. `slot`: batch * lane_count + lane of the balls' contact.
struct Candidate {
  std::int32_t a = 0, b = 0, slot = 0;
};

// Of a body's size: overlap up to this is left alone. Without it contacts that are pushed apart open by a little, fall
// shut again, and a heap never comes to rest.
inline constexpr double kSlopShare = 5e-4;

struct Law {
  double restitution = 0, friction = 0;
};

template <class S> struct FoundManifold {
  std::int32_t a = 0, b = 0;  // a moves
  Manifold<S> shape;          // normal from a to b
  Vec3<S> impulse_W[4];       // on b; from the last step where the point was there
  int slot = 0;               // batch * lane_count + lane
  Vec3<S> between_W;          // from a's centre to b's when it was found
};

// A pair of balls that pushed each other when the candidates were found anew.
template <class S> struct Kept {
  std::int32_t a, b;
  S impulse_n, impulse_t[3], normal[3];
};

// Round bodies with contacts that last (rolling.cpp): by body, but for the two lists.
template <class S> struct Rolling {
  bool some_round = false;  // some moving body is a cylinder or a capsule
  std::vector<int> bodies, manifolds;
  std::vector<unsigned char> rolls;
  std::vector<Vec3<S>> by_forces;    // what forces do to the body rate in a substep, world axes
  std::vector<Vec3<S>> by_contacts;  // what contacts did to it in the last one, rad/s^2
  std::vector<Vec3<S>> kicked;       // ... before they did
  std::vector<Vec3<S>> turned;       // since the step began, before the drift
};

// Who sleeps: empty unless the option is on.
struct Sleep {
  std::vector<int> island;      // of body i, by the number of one of its bodies; -1: awake
  std::vector<double> still_s;  // how long body i has been at rest
  std::vector<int> parent;      // union-find
};

// Room for what is built and thrown away.
template <class S> struct Scratch {
  Palette palette;
  std::vector<int> count, at, colour, other_colour;
  std::vector<Kept<S>> balls, planes;
  std::vector<std::vector<FoundManifold<S>>> found;  // one a part
  std::vector<std::vector<Manifold<S>>> shapes;      // one a part
  std::vector<std::vector<Manifold<S>>> renewed;     // one a manifold that is found anew
};

// ---- the direct solver's island at hand
template <class S> struct Point;  // points.hpp
template <class S> struct UnitImpulse { Vec3<S> along, at_a, at_b, turn_a, turn_b; };
template <class S> struct DirectSolver {
  std::vector<int> parent;                    // of bodies: union-find
  std::vector<std::pair<int, int>> contacts;  // point, island
  std::vector<int> left_out;                  // too far to push in this substep
  std::vector<Point<S>> points;
  std::vector<int> numbers;
  std::vector<UnitImpulse<S>> unit;  // three a point
  std::vector<S> W, q, l, step, z, z_try, F, F_try, change, l_try;
  DenseLu<S> lu{0};
  int n() const { return static_cast<int>(points.size()); }
  const S& w(int i, int j) const {
    return W[static_cast<std::size_t>(i) * (3 * points.size()) + static_cast<std::size_t>(j)];
  }
  S& w(int i, int j) { return W[static_cast<std::size_t>(i) * (3 * points.size()) + static_cast<std::size_t>(j)]; }
};

// ---- impacts within a substep
template <class S> struct Approach {
  S t_s{};
  int contact = 0;
};
template <class S> struct Impacts {
  std::vector<int> bouncing;        // contacts with restitution
  std::vector<int> first, of_body;  // those of body i: of_body[first[i]] .. of_body[first[i + 1]]
  std::vector<Approach<S>> queue;   // a heap, the earliest on top
  std::vector<Approach<S>> tied;    // of one instant, where the scene names an order
  std::vector<Manifold<S>> shapes;  // room
};

// A contact's impulse on b over a step, where somebody looks. The normal may turn meanwhile; friction stays in its
// cone: |across| <= mu size.
template <class S> struct Told {
  S size{};               // of the normal impulses
  Vec3<S> along, across;  // sums of the normal and of the tangential ones
};

// How fast the bodies of a contact without bounce came when the step began.
template <class S> struct Onset {
  int contact = 0;
  S vn_m_per_s{};
};

template <class S> struct World {
  Options options;
  const Scene* scene = nullptr;
  RigidModel<S>* model = nullptr;
  Team* team = nullptr;
  VectorWidth width = VectorWidth::narrow;
  std::vector<Geometry<S>> geometry;
  std::vector<Law> laws;  // of materials a, b at a * materials + b
  std::vector<std::int32_t> material;
  int materials = 0;
  bool bounces = false;  // some pair has restitution
  Vec3<S> gravity_W;
  bool by_mean = false;           // places by the mean of the velocities before and after, not by those after
  bool has_rest = false;          // some row of `rest` is not 0
  Stepper<S>* stepper = nullptr;  // null: symplectic Euler, fused; else free flight is its own
  std::vector<S> y, y_free;       // the state as the model lays it out
  S t_s{};                        // when the substep begins
  S h_s{}, sub_s{};               // a step, a substep
  int substeps = 1;
  int refused_points = 0;  // solver=direct: of an island that is too large for it; the run ends
  Profile* profile = nullptr;
  bool sums_impulses = false;          // somebody looks at the contacts of this step
  const Observer* observer = nullptr;  // null: nobody looks

  Bodies<S> bodies;
  Contacts<BallBatch<S>> balls;
  Contacts<ManifoldBatch<S>> manifold_batches;
  Impacts<S> impacts;
  std::vector<Onset<S>> onsets;
  std::vector<Told<S>> told;  // by the contact's number
  DirectSolver<S> direct;
  Rolling<S> rolling;
  Sleep sleep;
  std::vector<FoundManifold<S>> manifolds, manifolds_before;
  // manifolds whose bodies may move far within the step; that have, and are found anew
  std::vector<int> restless, stale;

  // candidates hold until some body left its margin
  std::vector<Candidate> ball_pairs, plane_pairs, other_pairs;
  std::unique_ptr<BroadPhase<S>> broad_phase;
  std::vector<BroadItem<S>> items;
  std::vector<std::int32_t> item_body;
  std::vector<BodyPair> found;
  // ... where he was when they were found; by what points of his surface have turned since
  std::vector<S> margin, turned;
  std::vector<Vec3<S>> found_at;
  bool candidates_hold = false, some_fixed = false;
  Scratch<S> scratch;

  const Law& law(int a, int b) const { return laws[static_cast<std::size_t>(material[a] * materials + material[b])]; }
};

// f(part's share of the batches of a colour, width); few batches stay on the caller's thread. Several parts a member,
// so that one who has lost his core delays the others by little.
template <class S, class F> void for_batches(World<S>& world, int first, int last, int worth, const F& f) {
  const auto work = [&](int from, int to) {
    in_lanes<S>(world.width, [&](auto width) ATWOOD_INLINED { f(from, to, width); });
  };
  const int count = last - first;
  if (world.team == nullptr || count < worth) return work(first, last);
  const int parts = std::min(4 * world.team->size(), 2 * count / worth);
  world.team->run(parts, [&](int part) {
    const Share own = share(count, part, parts);
    work(first + own.first, first + own.last);
  });
}

// A body's share of work for the team, or all of it.
template <class S, class F> void for_bodies(World<S>& world, const F& f) {
  const int count = world.bodies.count;
  if (world.team == nullptr || count < 1000) return f(0, count);
  world.team->run(true, [&](int part) {
    const Share own = share(count, part, world.team->size());
    f(own.first, own.last);
  });
}

// ---- step.cpp
// rows from world.y, under the model's present interval
template <class S> void load_bodies(World<S>& world);
template <class S> void set_kicks(World<S>& world);            // gravity's, for another substep
template <class S> void load_body(World<S>& world, int body);  // ... of one that moves
template <class S> void store_bodies(World<S>& world);         // and back
// false: free flight's implicit equations were not solved
template <class S> bool step(World<S>& world, S t_s, S h_s);

// R I^-1 R^T, entry by entry from the images of the world's axes; 1/m
template <class S> Row<S> inverse_inertia(const MassProperties<S>& mass, const Quat<S>& q_WB);

// ---- rolling.cpp
// Who rolls in the coming step of h_s, once contacts are found and kicks set.
template <class S> void list_rolling(World<S>& world, S h_s);
template <class S> void turn_rolling_inertias(World<S>& world);  // before a later substep's contacts
template <class S> void kick_rolling(World<S>& world, S sub_s);  // before the kick
template <class S> void look_ahead(World<S>& world, S sub_s);    // once contacts are prepared
template <class S> void turn_rolling(World<S>& world, S sub_s);  // after the drift

// ---- candidates.cpp
// Pairs that may touch within the coming step of h_s; those at hand serve as long as they hold.
template <class S> void find_candidates(World<S>& world, S h_s);

// ---- sleep.cpp: who sleeps stands as if fixed
template <class S> void fall_asleep(World<S>& world, S h_s);  // at a step's end
template <class S> void lay_down(World<S>& world, int body);  // its rows are those of a fixed body
// true: somebody woke; contacts are to be found again
template <class S> bool wake_whom_others_meet(World<S>& world);
template <class S> void wake_all(World<S>& world);

// ---- impacts.cpp
template <class S> void list_bouncing(World<S>& world);          // once a step
template <class S> void meet_impacts(World<S>& world, S sub_s);  // before the kick

// ---- seen.cpp: nothing here changes the motion
template <class S> void clear_sums(World<S>& world);
template <class S> void add_sums(World<S>& world);                                    // after each substep
template <class S> void tell_contacts(const World<S>& world, S h_s, Sample& sample);  // of the step just taken
// at the start of a step, where events are wanted
template <class S> void note_approaches(World<S>& world);
template <class S> void tell_onsets(World<S>& world);  // at its end

// ---- direct.cpp
// false: too many points; the sweeps are to go on, but see refused_points
template <class S> bool solve_directly(World<S>& world, bool rests);

// ---- balls.cpp
template <class S> void prepare_balls(World<S>& world, S h_s, bool push_apart, bool warm);
template <class S> void solve_balls(World<S>& world);

// ---- manifolds_found.cpp
template <class S> void find_manifolds(World<S>& world);  // once a step
// before a later substep: those whose bodies have moved against each other
template <class S> void renew_manifolds(World<S>& world);

// ---- manifolds.cpp
template <class S> void weigh_manifolds(World<S>& world);                       // mobilities
template <class S> void weigh_batch(World<S>& world, ManifoldBatch<S>& batch);  // ... of one batch alone
template <class S> void prepare_manifolds(World<S>& world, S h_s, bool push_apart, bool warm);
template <class S> void solve_manifolds(World<S>& world);

}  // namespace atwood::stepping
