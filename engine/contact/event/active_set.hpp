// Lasting contacts and their modes: which transmit a force, which slip, stick or roll.
//
// The active set is found by complementarity: each contact either has a normal force N >= 0 and no normal acceleration,
// or no force and an acceleration g'' >= 0; its friction either sticks within Coulomb's cone or slips on its surface
// (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, ch. 3 and 9; Pfeiffer and Glocker,
// Multibody Dynamics with Unilateral Contacts, 1996).
#pragma once

#include <cstdint>
#include <vector>

#include "contact/event/integration.hpp"
#include "contact/event/proximity.hpp"
#include "contact/event/report.hpp"
#include "protocol/solver_report.hpp"

namespace atwood::event {

template <class S> struct ConstraintSystem;
template <class S> struct EventRun;

enum class FrictionMode : unsigned char { frictionless, slip, stick };
enum class RollingMode : unsigned char { free, roll, stick };  // free: no rolling friction; stick: no relative rolling

// The bodies of a contact, -1 for one that does not move, and its lever arms: from each centre of mass to the contact
// point, world axes [m].
template <class S> struct LeverArms {
  int body[2] = {-1, -1};  // the feature's, the surface's
  Vec3<S> arm[2];
};

// A candidate that stays in contact. Directions, velocities and forces: of the feature's body relative to the
// surface's, world axes.
template <class S> struct Contact {
  int candidate = 0;
  Facet<S> facet;
  int last_triangle = 0;  // of a mesh: where the search for the nearest triangle begins
  FrictionMode mode = FrictionMode::frictionless;
  RollingMode rolling = RollingMode::free;
  bool active = false;         // transmits a normal force; otherwise it touches without one
  bool left_facet = false;     // has left its facet; the contact is to be removed
  bool at_cone_limit = false;  // in mode slip, its friction on the cone, but other contacts keep it from moving
  bool slip_onset = false;     // slip grows from zero within the step: keeps slip_direction throughout
  bool reached_cone = false, reached_rolling_bound = false;  // set by an event: friction, rolling couple at its bound
  S target_gap{};  // [m] the gap that projection restores: 0, or below for bodies that overlap at the start
  Vec3<S> slip_direction, roll_direction;  // unit
  S slip_speed{}, roll_speed{};            // [m/s], [rad/s] at the start of the segment

  // Kinematics at bodies.poses, and the version of the state they belong to (0: none).
  std::uint64_t kinematics_version = 0;
  GapKinematics<S> kinematics;
  LeverArms<S> levers;
  Vec3<S> u, w;  // [m/s] relative velocity at the contact point, [rad/s] relative angular velocity

  // Forces of the last evaluation, and the largest normal force since the contact became active.
  S normal_N{}, largest_N{};
  Vec3<S> friction_N, couple_N_m;
  // Ranges over a trial step: normal acceleration per 1 N with its friction [1/kg], and normal force [N].
  S min_delassus{}, max_delassus{}, min_normal_N{}, max_normal_N{};

  // Its share in the linear system of the last evaluation (constraints.hpp).
  bool decoupled = false;  // shares no moving body with another active contact: solved by itself (single_contact.hpp)
  bool between_spheres = false;  // what moves is a ball about its centre: a normal force does not turn it
  int first_row = -1;            // -1: it has no rows
  int force_rows = 1, couple_rows = 0;
  Vec3<S> tangent[2];                   // directions of the rows after the normal one
  Vec3<S> unit_force_W, unit_couple_W;  // per 1 N of normal force: that and friction of slip, couple of rolling
  // Initial guess of the solution; where contacts are redundant it selects one of the solutions.
  S warm_start_N{};
  Vec3<S> warm_start_friction_N, warm_start_couple_N_m;

  // Of solve_forces_gauss_seidel() only: relative accelerations, and inverse effective masses [1/kg], [1/(kg m^2)].
  Vec3<S> u_dot, alpha;
  S inverse_mass_n{}, inverse_mass_t{}, inverse_inertia_r{};
};

template <class S> struct ActiveSet {
  std::vector<Contact<S>> contacts;    // all that touch, active or not
  int count = 0;                       // of active contacts
  std::vector<int> bodies;             // of the contacts' bodies that are not fixed, each once
  std::int64_t active_set_epoch = -1;  // of the equations of motion (System::epoch) that the set is valid for
  bool is_first_step = true;           // impacts come before contacts
  std::uint64_t mode_key = 0;          // of the contacts and modes that `decoupled` is known for
  bool force_near_bound = false;       // in the present trial step a force came within a tenth of its bound
  S separation_acceleration{};         // [m/s^2] normal accelerations below it are round-off
  int inconsistent = -1;      // index of the pair without a contact force by Coulomb's law (painleve.hpp); -1: none
  S last_painleve_s = S(-1);  // time [s] of the last impact without collision; -1: none
  int painleve_impacts = 0;   // how many there were before at that instant

  // Working memory.
  std::vector<Contact<S>> previous, kept;
  std::vector<unsigned char> previous_states;  // PairState of each previous contact's pair
  std::vector<int> contacts_on_body;           // a body: active contacts on it
};

// Finds the contacts, their modes and forces at states.y, for the law that holds from t_s on, and reports changes of
// mode as events. False: no forces obey the laws, or the run is refused; report.outcome says which.
template <class S> bool update_active_set(EventRun<S>& run, S t_s);
template <class S>
void report_event(const Report& report, EventKind kind, const ShapePair<S>& pair, const GapKinematics<S>& kinematics,
                  bool feature_is_a, const Impulse<S>& impulse, S t_s);

}  // namespace atwood::event
