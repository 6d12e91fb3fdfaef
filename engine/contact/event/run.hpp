// A run of `+event`: free flight by the method, impacts located on its flow, and between them contacts that last, held
// by the forces that their geometry and Coulomb's law ask for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "collision/geometry.hpp"
#include "contact/event/edges.hpp"
#include "contact/event/features.hpp"
#include "contact/impulse.hpp"
#include "integrators/free_flight.hpp"
#include "integrators/stepper.hpp"
#include "protocol/method.hpp"
#include "protocol/sample.hpp"
#include "rigid/model.hpp"

namespace atwood::event {

// Two bodies that may touch, with the knobs and surfaces by which they do.
template <class S> struct ShapePair {
  int a = 0, b = 0;          // a < b
  int first = 0, count = 0;  // features
  S restitution{}, friction{}, rolling_friction_m{};
  S reach{};       // of both bodies' bounding spheres; a plane's is 0
  int plane = -1;  // surface, if one of them is a plane
  bool plane_is_a = false;
  std::string past_the_end;    // why corners must not slide over the end of what they stand on; empty: they cannot
  std::string refused;         // not empty: no test for this pair; it must not come near
  S look_again_at{};           // the two bodies' travel until which they cannot have met
  std::int64_t known_at = -1;  // step at whose start its features' gaps are known
  bool ends = false;           // this instant's impact ends its series of bounces, tail_s later
  S tail_s{}, ends_s{};        // ends_s: when its series will have ended, as its impacts so far tell
  bool lists_edges = false;    // its edges are among its features; else [first_, + count_without_edges) are all
  int first_without_edges = 0, count_without_edges = 0;
};

// A body of corners, end balls or rims and the sheet, flat mesh or box that they may stand on, whose ends they do not
// know.
template <class S> struct SheetEnds {
  int pair = 0, knob_body = 0, surface_body = 0;
  Geometry<S> knob, surface;
  Vec3<S> on_it_B, normal_B;
  bool thick = false;  // a box: it has no other side; what passes it within a step may cross its edges alone
};

// A feature that touches at the instant of an impact.
template <class S> struct Hit {
  int feature = 0, pair = 0;
  Sight<S> sight;
  ImpactBody<S> surface, knob;
  S mobility_n{}, mobility_t{};
  S before{}, target{}, least{}, normal_N_s{};  // v_n before, ... to reach; normal impulse at least, and so far
  Vec3<S> tangential_N_s;
};
template <class S> struct Pending {
  int pair = 0;
  bool knob_is_a = false;
  Sight<S> sight;
  Impulse<S> impulse;
};

template <class S> struct Feature {
  int pair = 0, knob_body = 0, surface_body = 0, surface = 0;
  Knob<S> knob;
  int edge[2] = {-1, -1};         // an edge over an edge: of the knob's and the surface's body in EventRun::edges
  mutable int over_triangle = 0;  // of a flat mesh: where it was last, and is looked for first
  bool lasting = false;           // among EventRun::contacts
  S gap{}, rate{};                // at the start of the step, where its pair's are known
  S gap_end{}, rate_end{};
};

enum class Mode : unsigned char { smooth, slips, sticks };  // smooth: no friction
enum class Turning : unsigned char { free, rolls, held };   // free: no rolling friction

// Where a contact acts: its point as its two bodies see it.
template <class S> struct Place {
  int body[2] = {-1, -1};  // the knob's, the surface's; -1: does not move
  Vec3<S> arm[2];
};

// A knob that keeps touching. Directions and forces: of the knob's body against the surface's, world axes.
template <class S> struct Contact {
  int feature = 0;
  Facet<S> facet;
  int over_triangle = 0;  // of a mesh: the last that it was within
  Mode mode = Mode::smooth;
  Turning turning = Turning::free;
  bool carries = false;  // a normal force is solved for; else it touches, and others carry
  bool left = false;     // is past the end of its facet: no contact any more
  bool waits = false;    // stands at the edge of its cone, with no slip yet
  bool sets_in = false;  // slips too slowly to turn within a step, and faster and faster: along slip_direction
  bool gives_way = false, turns_over = false;  // what an event found: friction, couple at its bound
  S rest_gap{};                                // what the gap is held at: below 0 for bodies that overlap at the start
  Vec3<S> slip_direction, roll_direction;
  S slip_speed{}, roll_speed{};  // at the start of the step
  // Of the last evaluation:
  Sight<S> sight;
  Place<S> place;
  Vec3<S> u, w;               // slip velocity of the knob's point, relative angular velocity
  S normal_N{}, largest_N{};  // now; since it carries
  Vec3<S> friction_N, couple_N_m;
  bool alone = false;  // shares no moving body with another contact that carries: solved by itself (alone.cpp)
  S least_yield{}, most_yield{};  // normal acceleration per 1 N with its friction: in a trial step's evaluations
  bool of_balls = false;          // and who moves is a ball: a force through the middle does not turn it
  int first_row = -1, force_rows = 1, couple_rows = 0;  // -1: none of the linear system's
  Vec3<S> tangent[2];                                   // of the rows after the normal one
  Vec3<S> along_W, along_couple_W;  // what comes with 1 N along the normal: that and friction, a couple
  S share_N{};  // of the load, where contacts are redundant: as settled when they last changed, then of the last step
  Vec3<S> share_friction_N, share_couple_N_m;
  // Of settle_forces() alone:
  Vec3<S> u_dot, alpha;
  S mobility_n{}, mobility_t{}, mobility_c{};
};

// Of one body, world axes: a direction in its velocities, a load on it, or its acceleration.
template <class S> struct Twist { Vec3<S> linear, angular; };
template <class S> S dot(const Twist<S>& a, const Twist<S>& b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}

// What is asked of the accelerations of a contact's two bodies, and what a unit of the load for it does to them.
template <class S> struct Row {
  int body[2] = {-1, -1};      // the knob's, the surface's; -1: does not move
  Twist<S> row[2], answer[2];  // of each body: the sum of row . acceleration is asked for; acceleration
};

// Of mass and inertia, world axes
template <class S> struct Inverse {
  S mass_per_kg{};
  Vec3<S> I_row[3];
};

// |u| u has a kink at u = v - wind = 0
template <class S> struct Wind {
  int body = 0;
  Vec3<S> velocity_W;
};

struct EventOptions {
  Restitution restitution = Restitution::newton;
  bool together = false;  // one solve for all impacts of an instant, instead of pair after pair
};

template <class S> struct EventRun {
  EventRun(RigidModel<S>& of_model, Stepper<S>& of_stepper) : model(of_model), stepper(of_stepper) {}

  RigidModel<S>& model;
  Stepper<S>& stepper;
  EventOptions options;
  std::unique_ptr<Stepper<S>> substitute;  // for lasting contacts, where the method asks for no rates
  std::unique_ptr<Stepper<S>> fine;        // for slip that turns as it ends
  bool slip_ends = false;                  // such are the steps now
  FreeFlight<S>* free_flight =
      nullptr;  // the stepper's equal steps, bit for bit, while no contact carries; may be null
  std::vector<ShapePair<S>> pairs;
  std::vector<Feature<S>> features;
  std::vector<Surface<S>> surfaces;
  std::vector<SheetEnds<S>> ends;
  std::vector<std::vector<Edge<S>>> edges;  // a body's
  int edge_surface = -1;
  std::size_t features_without_edges = 0, surfaces_without_edges = 0;
  std::vector<Wind<S>> winds;
  std::vector<Pose<S>> poses;                // of every body; fixed ones never change
  std::vector<S> travel, excursions, reach;  // a body: the length of its way so far, within the step; bounding radius
  std::vector<S> mobility;                   // a body: at least what a unit force gives any of its points
  std::vector<unsigned char> moves;          // neither fixed nor held now
  std::vector<unsigned char> round;          // isotropic inertia
  std::vector<int> near;                     // pairs looked at in this step
  std::vector<Contact<S>> contacts, contacts_before, contacts_guessed;
  std::vector<unsigned char> standing_before;  // of contacts_before (modes.cpp)
  std::vector<Hit<S>> hits;
  std::vector<Pending<S>> pending;  // events of the impacts of an instant
  std::vector<int> contact_bodies;  // each once
  std::vector<int> touches;         // a body: contacts that carry on it
  int carrying = 0;

  // ---- the model's own equations, which those with contacts wrap
  void (*free_rate_of)(void*, S, const S*, S*) = nullptr;
  void (*free_project_of)(void*, S*) = nullptr;
  void (*free_projection_of)(void*, const S*, S*) = nullptr;
  void* free_context = nullptr;
  std::int64_t wrapped_calls = 0;

  // ---- linear algebra of the contacts
  std::vector<Row<S>> rows;  // room for them: the first row_count are in use
  int row_count = 0, row_contacts = 0;
  std::vector<Inverse<S>> inverse;  // of moving bodies; kept up where they are posed as contact_bodies
  std::vector<S> matrix, right, unknown, residual, start, weight, diagonal;
  std::vector<int> pivots, block_ends;
  bool has_factors = false;                 // matrix: of the rows of an earlier evaluation, and
  std::uint64_t modes = 0, factors_of = 0;  // which contacts carry in which modes: of this evaluation, of the matrix
  bool answered = false;                    // acceleration: under these unknowns
  std::vector<unsigned char> loaded;        // a body: by some of them
  std::vector<Twist<S>> free_acceleration, acceleration;  // of bodies in one evaluation: without and with them
  bool near_bound = false;  // in an evaluation of this step a force came near to its bound
  bool solvable = true;
  S rises_enough{};              // a normal acceleration that is none, as forces are known
  int inconsistent = -1;         // a pair for which Coulomb's law has no contact force (painleve.cpp)
  S struck_s = S(-1);            // the last impact without collision,
  int strikes = 0;               // and how many there were at that instant before
  bool sights_at_end = false;    // the contacts' last sights, and the bodies' poses, are of y_new
  bool sights_at_start = false;  // ... are of y

  // ---- states
  std::vector<S> y, y_new, y_probe, y_kept, dydt;
  S length_scale{};  // of coordinates and sizes: what round-off of a gap is relative to
  S speed_scale{};   // largest speed of a body's points so far
  S rtol{}, atol{}, h_next_s{};
  std::int64_t seen_epoch = -1, step_count = 0;
  bool starts = true;  // nothing is known of contacts yet
  const Observer* observer = nullptr;
  Outcome outcome;

  S gap_round_off() const { return S(64) * real::epsilon<S>() * length_scale; }
  S approach_round_off() const { return S(256) * real::epsilon<S>() * speed_scale; }
  S slip_round_off() const { return S(4096) * real::epsilon<S>() * speed_scale; }
};

// ---- pairs.cpp
template <class S> void find_pairs(EventRun<S>& run, const Scene& scene);

// ---- motion.cpp: poses, gaps
template <class S>
void take_pose(const EventRun<S>& run, int body, const S* y, Pose<S>& pose);  // a fixed body's stays as it is
template <class S> Pose<S> pose_of(const EventRun<S>& run, int body, const S* y);
template <class S>
void pose_bodies(EventRun<S>& run, const Feature<S>& feature, const S* y);  // the two of them, into run.poses
template <class S> Vec3<S> outermost_of(const EventRun<S>& run, const Feature<S>& feature);  // run.poses are current
template <class S>
Facet<S> facet_under(const EventRun<S>& run, const Feature<S>& feature, S& beside);  // run.poses are current
// Centred balls on planes and balls need no axes of their bodies.
template <class S> bool needs_axes(const EventRun<S>& run, const Feature<S>& feature) {
  return !feature.knob.centered || run.surfaces[feature.surface].kind > SurfaceKind::point;
}
template <class S> Sight<S> sight_of_ball(const EventRun<S>& run, const Feature<S>& feature, const S* y);  // of such
template <class S> Sight<S> posed_sight(const EventRun<S>& run, const Feature<S>& feature);  // run.poses are current
template <class S> Sight<S> sight_of(EventRun<S>& run, const Feature<S>& feature, const S* y);
template <class S> ImpactBody<S> impact_body(const EventRun<S>& run, int body, const Vec3<S>& x_W);  // from run.poses
template <class S> void store_velocity(EventRun<S>& run, int body, const Vec3<S>& v_W, const Vec3<S>& w_W, S* y);

// ---- forces.cpp: contact forces in the rates
template <class S> void wrap_rates(EventRun<S>& run);
template <class S> void unwrap_rates(EventRun<S>& run);
template <class S> void contact_rates(EventRun<S>& run, S t_s, const S* y, S* dydt);
template <class S> void keep_shares(EventRun<S>& run);  // of the last evaluation: where the next step's solutions start
// The contact's relative acceleration along n and across it, with all forces in `dydt`.
template <class S> Vec3<S> relative_acceleration(const EventRun<S>& run, const Contact<S>& contact, const S* dydt);
template <class S> S normal_acceleration(const EventRun<S>& run, const Contact<S>& contact, const S* dydt);
template <class S> Vec3<S> relative_turning(const EventRun<S>& run, const Contact<S>& contact, const S* dydt);

// ---- rows.cpp: contacts as conditions on their bodies' accelerations
template <class S> void hold_inverses(EventRun<S>& run);  // once: of bodies whose inertia does not turn
template <class S> void pose_contact_bodies(EventRun<S>& run, const S* y);
template <class S> void see_contact(EventRun<S>& run, Contact<S>& contact);  // from run.poses
template <class S> void see_contacts(EventRun<S>& run, const S* y);          // those that carry
// What rows are for: under the loads that forces are, under pure ones, along normals alone.
enum class Rows : unsigned char { forces, velocities, gaps };
template <class S>
void take_direction(const EventRun<S>& run, Contact<S>& contact, Rows what);  // along_W, along_couple_W
template <class S>
void list_unknowns(EventRun<S>& run, Rows what);        // of contacts that carry; forces: and are not alone
template <class S> void fill_matrix(EventRun<S>& run);  // and run.diagonal
template <class S>
void answer_unknowns(EventRun<S>& run);  // run.acceleration of contact_bodies, under them and the free one
template <class S> void read_rows(const EventRun<S>& run, const Contact<S>& contact, S* values);  // of run.acceleration
template <class S> void read_unknowns(const EventRun<S>& run, Contact<S>& contact);  // as forces and a couple
// What a force and a couple on the knob's body (the opposite on the surface's) do; and along a force and a couple of
// the same kind.
template <class S>
Row<S> load_row(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& force, const Vec3<S>& couple);
template <class S>
S effect_of_load(const EventRun<S>& run, const Contact<S>& contact, const Vec3<S>& on, const Vec3<S>& on_couple,
                 const Vec3<S>& force, const Vec3<S>& couple);

// ---- facets.cpp: does the contact's surface end? How far its knob is from leaving the facet it is on (poses are
// current); the facet that it leaves for, or false: no contact is known there.
template <class S> bool has_ends(const EventRun<S>& run, const Contact<S>& contact);
template <class S> S within_facet(const EventRun<S>& run, Contact<S>& contact);
template <class S> bool leave_facet(EventRun<S>& run, Contact<S>& contact);
// The deepest gap at which a pair is held in y: bodies that overlap at the start stay so, and within a step a lasting
// contact's gap drifts by the method's error.
template <class S> S held_at(const EventRun<S>& run, int pair, const S* y);
template <class S> bool clear_of_end(EventRun<S>& run, const SheetEnds<S>& ends, const S* y);
// False: something lies over the end of a sheet in y. Does a body come to a sheet's other side on the way?
template <class S> bool clear_of_ends(EventRun<S>& run, const S* y);
template <class S> bool passes_a_sheet(const EventRun<S>& run, const S* y, const S* y_end);

// ---- alone.cpp: the contact's forces, solved for and added to the rates; false: there are none
template <class S> bool add_alone(const EventRun<S>& run, Contact<S>& contact, S* dydt);

// ---- project.cpp
// Takes drift off the constraints: positions along the normals, velocities as the impulse that costs least energy.
template <class S>
void project_contacts(EventRun<S>& run, S* y, bool seen = false);  // seen: the contacts' sights are of y

// ---- linear.cpp: run.matrix unknown = run.right, of run.row_count rows; where redundant contacts make it singular,
// the solution nearest to what stands in run.unknown, unknowns weighted by run.weight; keep_factors: those of an
// earlier solve will do
template <class S> void solve_rows(EventRun<S>& run, bool redundant, bool keep_factors = false);

// ---- settle.cpp: normal forces, friction and couples of run.contacts, and u_dot, alpha under them; `free_dydt`:
// without contacts. Where slip sets in, friction opposes the slip at the end of a step of 1 / rate_per_s, whose
// direction becomes slip_direction.
template <class S> void settle_forces(EventRun<S>& run, const S* free_dydt, S rate_per_s);

// ---- slip.cpp: of what slips, with the rates at run.y in run.dydt. Does its direction, or a spin that has a say in
// it, turn within that time; does it move already; does it hardly change its speed, friction and what drives it in
// balance?
struct SlipTurn {
  bool turns = false, moves = false, slow = false;
};
template <class S> SlipTurn slip_turn(const EventRun<S>& run, S within_s);

// ---- modes.cpp: which contacts touch, carry, slip, stick at this instant; `forced`: a contact whose friction is at
// its bound
template <class S> bool review_contacts(EventRun<S>& run, S t_s, bool report);
template <class S>
void report_event(const EventRun<S>& run, EventKind kind, const ShapePair<S>& pair, const Sight<S>& sight,
                  bool knob_is_a, const Impulse<S>& impulse, S t_s);

// ---- painleve.cpp: are the forces that were found the only ones? False: others obey the laws as well, the run ends.
// Where none obey them, run.inconsistent is the pair, whose impact without collision strike() takes, with all impacts
// that follow from it; false: it has no answer, the run ends.
template <class S> bool judge_forces(EventRun<S>& run, S t_s, S tiny_acceleration, S tiny_N);
template <class S> bool strike(EventRun<S>& run, S t_s);
// In the evaluations of a trial step: does the normal acceleration that a force gives vanish, or change too much for
// the method to follow next to where it does? False: the step must be shorter.
template <class S> void note_yield(Contact<S>& contact, S yield);
template <class S> void forget_yields(EventRun<S>& run);
template <class S> bool keeps_off_singularity(const EventRun<S>& run);
template <class S> bool near_singularity(const EventRun<S>& run);              // is some such acceleration small?
template <class S> bool refuse_at(EventRun<S>& run, S t_s, const char* what);  // ends the run as unsupported; false

// ---- impacts.cpp: the impacts of an instant, at run.y
template <class S> bool resolve_impacts(EventRun<S>& run, S t_s);

// ---- near.cpp: which pairs to look at in the step from run.y to run.y_new, and gaps at its ends
template <class S> bool find_near(EventRun<S>& run, S h_s);  // false: a pair comes near for which there is no test
template <class S> void measure_gaps(EventRun<S>& run);
template <class S> void advance_travel(EventRun<S>& run);  // after each piece of a step
template <class S> void pass_gaps_on(EventRun<S>& run);    // ... if it went its whole way

// ---- step.cpp
template <class S> bool step_with_events(EventRun<S>& run, S t_s, S h_s);

}  // namespace atwood::event
