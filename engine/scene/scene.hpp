// What is simulated: plain data, SI units, units in the names. Nothing here computes.
//
// Vectors are in world axes unless the name says `_body`. Orientation is a unit quaternion (w, x, y, z), body to
// world. Matrices are row-major. A Scene is *resolved*: defaults filled, grids expanded, inertia computed, the law of
// every pair of materials tabulated. The problem is the scene after its decimals are rounded to double.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "scene/fluid.hpp"
#include "scene/interval.hpp"
#include "scene/joint.hpp"

namespace atwood {

using Real2 = std::array<double, 2>;
using Real3 = std::array<double, 3>;
using Real4 = std::array<double, 4>;
using Real33 = std::array<double, 9>;

// ---- shapes ----------------------------------------------------------------------------------------------------
// clang-format off
struct Sphere { double radius_m = 0; };
struct Plane { Real3 normal{0, 0, 1}; double offset_m = 0; };  // n . x = offset on the plane; infinite, fixed
struct Rectangle { Real2 half_extents_m{}; };                  // in the body's x, y; normal +z
struct Box { Real3 half_extents_m{}; };
struct Capsule { double radius_m = 0; double half_length_m = 0; };   // along body z
struct Cylinder { double radius_m = 0; double half_length_m = 0; };  // along body z
struct Convex { std::vector<Real3> points_m; };
struct Mesh { std::string file; std::vector<Real3> points_m; std::vector<std::array<int, 3>> triangles; };
// clang-format on
struct Compound {
  struct Part {
    Real3 half_extents_m{};
    Real3 position_body_m{};
    Real4 orientation_wxyz{1, 0, 0, 0};
  };
  std::vector<Part> boxes;
};
using Shape = std::variant<std::monostate, Sphere, Plane, Rectangle, Box, Capsule, Cylinder, Convex, Mesh, Compound>;

// ---- bodies and materials -------------------------------------------------------------------------------------
struct Material {
  std::string name;
  double restitution = 0;
  double friction = 0;
  double rolling_friction_m = 0;
};

// Contact law under an overlap d >= 0, for methods that resolve the duration of a contact and not only its outcome.
enum class ContactLaw {
  rigid,   // no compliant law: impacts are instantaneous
  linear,  // F = stiffness d + damping d'
  hertz    // F = 4/3 E sqrt(R) d^(3/2) (1 + damping d'), 1/R = 1/r_a + 1/r_b (a plane: 1/r = 0)
};

// The law of one unordered pair of materials (indices into Scene::materials, a <= b).
struct PairLaw {
  int a = 0, b = 0;
  double restitution = 0;
  double friction = 0;
  double rolling_friction_m = 0;
  ContactLaw contact_law = ContactLaw::rigid;
  double stiffness_N_per_m = 0;  // linear
  double damping_N_s_per_m = 0;  // linear
  bool pull = false;             // linear: F may be negative until the overlap ends; otherwise F >= 0
  double modulus_Pa = 0;         // hertz: E, 1/E = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b
  double damping_s_per_m = 0;    // hertz
};

struct Body {
  std::string name;
  double mass_kg = 0;      // 0 when fixed
  Real33 inertia_kg_m2{};  // about the centre of mass, body axes; all zero: a point mass, which does not rotate
  int material = 0;        // index into Scene::materials
  Shape shape;
  Real3 position_m{};  // of the centre of mass
  Real4 orientation_wxyz{1, 0, 0, 0};
  Real3 velocity_m_per_s{};
  Real3 angular_velocity_body_rad_per_s{};
  double charge_C = 0;
  bool fixed = false;
  double release_s = 0;  // held until then
};

// ---- forces ---------------------------------------------------------------------------------------------------
// `bodies` are indices into Scene::bodies.
struct MutualGravity {
  std::vector<int> bodies;
  double constant_m3_per_kg_s2 = 6.6743e-11;
  double softening_m = 0;
};
struct Attractor {
  std::vector<int> bodies;
  Real3 center_m{};
  double mu_m3_per_s2 = 0;
};
struct LinearDrag {  // F = -coefficient u, u = v - wind; torque = -angular_coefficient w
  std::vector<int> bodies;
  double coefficient_kg_per_s = 0;
  Real3 wind_m_per_s{};
  double angular_coefficient_N_m_s = 0;
};
struct QuadraticDrag {  // F = -1/2 rho C_d A |u| u
  std::vector<int> bodies;
  double density_kg_per_m3 = 0;
  double drag_coefficient = 0;
  double area_m2 = 0;
  Real3 wind_m_per_s{};
  double angular_coefficient_N_m_s = 0;
};
struct Spring {  // one body and an anchor, or two bodies; points in body axes, one per body
  std::vector<int> bodies;
  Real3 anchor_m{};
  double stiffness_N_per_m = 0;
  double damping_N_s_per_m = 0;
  double rest_length_m = 0;
  std::vector<Real3> points_body_m;
};
struct Drive {
  std::vector<int> bodies;
  Real3 force_N{};
  double angular_frequency_rad_per_s = 0;
  double phase_rad = 0;
};
// F = q (E + v x B)
struct Lorentz {
  std::vector<int> bodies;
  Real3 electric_V_per_m{};
  Real3 magnetic_T{};
};
struct Coulomb {
  std::vector<int> bodies;
  double constant_N_m2_per_C2 = 0;
};
struct Thruster {  // force thrust * R direction_body at R point_body, while on
  int body = 0;
  Real3 point_body_m{};
  Real3 direction_body{};
  double thrust_N = 0;
  std::vector<Interval> on_s;
};
struct PointForce {  // force fixed in the world at a point fixed in the body; on_s empty: always on
  int body = 0;
  Real3 point_body_m{};
  Real3 force_N{};
  std::vector<Interval> on_s;
};
// a = -2 W x v - W x (W x r), on every point mass
struct RotatingFrame {
  Real3 angular_velocity_rad_per_s{};
};
// F = -grad V
struct Potential {
  std::vector<int> bodies;
  std::string name;
  std::map<std::string, double> parameters;
};
using Force = std::variant<MutualGravity, Attractor, LinearDrag, QuadraticDrag, Spring, Drive, Lorentz, Coulomb,
                           Thruster, PointForce, RotatingFrame, Potential>;

// ---- the scene ------------------------------------------------------------------------------------------------
// What happens when several contacts of one connected group have an impact at the same instant.
enum class SimultaneousImpacts {
  unspecified,  // a truth ends if the outcome depends on a convention
  sequential,   // pair by pair, the fastest approach first, ties in the order of the bodies, until none approaches
  together      // one solve with the impulses of all contacts of the group (Moreau 1988)
};

struct Scene {
  // A bare system of equations from the catalogue instead of bodies ("lorenz"). It appears as one body of that name:
  // its three unknowns are the body's position, their rates its velocity; position_m is the initial state.
  std::string problem;
  Real3 gravity_m_per_s2{};
  SimultaneousImpacts simultaneous_impacts = SimultaneousImpacts::unspecified;
  std::vector<Material> materials;  // at least one; index 0 is used by bodies that name none
  std::vector<PairLaw> pairs;       // every unordered pair of materials
  std::vector<Body> bodies;         // may be empty where there is a fluid
  std::vector<Force> forces;
  // A body with a placing joint has the pose and velocity that follow from its joints, rounded to double.
  std::vector<Joint> joints;
  std::vector<Rope> ropes;
  std::vector<JointForce> joint_forces;
  Domain domain;
  std::vector<Fluid> fluids;
  std::vector<FluidBoundary> fluid_boundaries;
  std::vector<FluidProbe> probes;
};

// ---- the scenario: a scene with a claim, a truth and a ladder -----------------------------------------------
// `weakly_compressible`: the equations of a weakly compressible fluid, solved by a spectral method. `semi_discrete`:
// the particles' own equations of motion, whose solution has no error of time. `literature`: published values with a
// band.
enum class TruthKind { closed_form, extended, cvode, values, none, weakly_compressible, semi_discrete, literature };
struct TruthSpec {
  TruthKind kind = TruthKind::none;
  std::string solution;  // closed_form: the id of the solution
  std::string file;      // values: CSV in the scene's folder (the truth's own format, resolved path)
  // semi_discrete, weakly_compressible: the particles' equations ("sph{...}"); of a cell, not in JSON
  std::string response = {};
};
// energy, momentum, angular-momentum, center-of-mass, jacobi-constant, ...
struct Invariant {
  std::string quantity;
};

struct Scenario {
  std::string id, title, claim, source;
  std::vector<std::string> tags;
  double t_end_s = 0;
  std::vector<std::int64_t> steps;   // the ladder
  std::int64_t samples = 0;          // divides every step count
  std::vector<double> frame_ends_s;  // recorded frames instead of equal steps; empty: none
  // Of scenes with fluids: the ladders of the particles' spacing and of the sound speed, the coarsest and the slowest
  // first. `steps` are those of the first entries; for other entries they are scaled by the ratios of spacing and of
  // speed, so that the Courant number stays. `scene` is at the first entries. Empty: as the fluids say.
  std::vector<double> spacings_m, sound_speeds_m_per_s;
  Scene scene;
  TruthSpec truth;
  std::vector<Invariant> invariants;
  std::string path;                     // the file it was read from; empty when it came by JSON
  std::vector<std::string> notes = {};  // what reading changed, in sentences ("... was normalised"); not part of JSON
};

inline bool rotates(const Body& body) { return body.inertia_kg_m2 != Real33{}; }

// The law of two bodies' materials.
const PairLaw& pair_law(const Scene& scene, int body_a, int body_b);

}  // namespace atwood
