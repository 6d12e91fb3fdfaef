// Contacts as the solvers store them: eight contacts of one kind in the lanes of a batch, batches ordered by colour.
//
// Two contacts share a colour only if they share no moving body. The batches of a colour can therefore be solved at the
// same time, by any number of threads, and the result does not depend on their order (graph colouring of the contact
// graph, as in Box2D).
//
// Conventions: the normal n is a unit vector from body a to body b; impulses act on b, their opposites on a; arms reach
// from the centre of mass of a body to the contact point. Vectors have world axes; SI units.
#pragma once

#include <cstdint>
#include <vector>

#include "collision/contacts.hpp"
#include "contact/stepping/rows.hpp"

namespace atwood::stepping {

// Coefficients of a pair of materials.
struct PairCoefficients {
  double restitution = 0, friction = 0;
};

// Overlap up to this share of a body's size is left uncorrected (Box2D's linear slop). Without it corrected contacts
// would open a little and close again, and a heap would never come to rest.
inline constexpr double kSlopPerSize = 5e-4;

// What body b of a sphere contact is. A manifold contact does not use it.
enum class SpherePartner : unsigned char { moving_sphere, fixed_sphere, plane };

// Eight contacts of a moving sphere a with a sphere or a plane b.
template <class S> struct SphereBatch {
  std::int32_t a[kLaneCount], b[kLaneCount];  // bodies; unused lanes hold the number of the zero row
  std::int32_t count = 0;                     // lanes in use
  bool active = false;                        // some lane may touch within the substep: the sweeps visit the batch
  Lanes<S> normal[3];
  Lanes<S> radius_a, radius_b;  // m; of a plane: its offset along -normal, which makes gap = -n . p_a - (r_a + r_b)
  Lanes<S> friction, restitution;
  Lanes<S> slop;                     // m; overlap that is left uncorrected
  Lanes<S> gap;                      // m; signed distance of the surfaces, negative: overlap
  Lanes<S> bias;                     // m/s; velocity bias: the solver asks for u_n + bias >= 0
  Lanes<S> arm_a, arm_b;             // m; from the centres to the point midway between the surfaces, along the normal
  Lanes<S> mass_n, mass_t;           // kg; effective masses along the normal and across it
  Lanes<S> impulse_n, impulse_t[3];  // N s
};

// Which points of a body's surface stay in place when the body rotates: those of a sphere of `radius_m` about the
// centre of mass or about a capsule's axis (0: none), and a surface of revolution about the unit vector `axis` (0:
// none).
template <class T> struct Rounding {
  Vec3<T> axis;
  T radius_m;
};

// The gap of a lane that has no such point, and the bias of a contact that is not a constraint [m, m/s]; all others are
// below kMaxValue.
inline constexpr double kNoValue = 1e30, kMaxValue = 1e29;

// One point of eight manifolds.
template <class S> struct ManifoldPoint {
  Lanes<S> r_a[3], r_b[3];           // m; from the centres of mass to the point, when the manifold was detected
  Lanes<S> gap_at_detection;         // m; kNoValue: this lane has no such point
  Lanes<S> gap, bias;                // m, m/s; as in SphereBatch
  Lanes<S> arm_a[3], arm_b[3];       // m; to the point midway between the surfaces, now
  Lanes<S> mass_n;                   // kg; effective mass along the normal
  Lanes<S> mass_t[3];                // kg; inverse of the 2 x 2 tangential mobility, entries tt, ts, ss
  Lanes<S> gradient_step_t;          // kg; 1 / larger eigenvalue of that mobility: step of the projected gradient
  Lanes<S> impulse_n, impulse_t[2];  // N s; tangential ones along t and s = n x t
};

// Eight manifolds of up to four points each.
template <class S> struct ManifoldBatch {
  std::int32_t a[kLaneCount], b[kLaneCount];  // bodies; a moves
  std::int32_t manifold[kLaneCount];          // index in World::manifolds
  std::int32_t count = 0, points = 0;         // lanes in use; the most points that one of them has
  Lanes<S> normal[3], tangent[3];             // unit and perpendicular; the second tangent is s = n x t
  Lanes<S> friction, restitution, slop;
  // what advance_point() needs to know of the surfaces (contact_points.hpp)
  Lanes<S> rounding_axis_a[3], rounding_axis_b[3], rounding_radius_a, rounding_radius_b, witness_offset;
  Lanes<S> rotation_a[3], rotation_b[3];  // rotation vectors of the bodies since the step began, at detection
  ManifoldPoint<S> point[4];
  bool has_surface_velocity = false;  // some entry of `surface_velocity` is not 0
  Lanes<S> surface_velocity[4][2];    // m/s along t and s, of each point; added to its slip velocity (rolling.cpp)
};

// Batches [first, last): no two of their contacts share a moving body.
struct Colour {
  int first = 0, last = 0;
  SpherePartner partner = SpherePartner::moving_sphere;
};

template <class Batch> struct ColouredBatches {
  std::vector<Batch> batches;
  std::vector<Colour> colours;
  void clear() {
    batches.clear();
    colours.clear();
  }
};

// A pair of bodies whose bounding volumes, enlarged by their margins, overlap. `slot`: batch * kLaneCount + lane of its
// contact, where it is a pair of spheres or of a sphere and a plane.
struct CandidatePair {
  std::int32_t a = 0, b = 0, slot = 0;  // a moves
};

// A manifold as the narrow phase found it, with the impulses of its points.
template <class S> struct ContactManifold {
  std::int32_t a = 0, b = 0;  // bodies; a moves
  Manifold<S> geometry;       // normal from a to b
  Vec3<S> impulse_W[4];       // N s, on b: of the last substep in which the point existed
  int slot = 0;               // batch * kLaneCount + lane
  Vec3<S> offset_W;           // m; from a's centre of mass to b's, at detection
};

// The accumulated impulse of a sphere contact, while the batches are built anew.
template <class S> struct StoredImpulse {
  std::int32_t a, b;
  S impulse_n, impulse_t[3], normal[3];
};

}  // namespace atwood::stepping
