// Rigid contacts during a CVODE run: where they begin and end, impacts, balls that rest on a plane. In double.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "cvode/compliant_contacts.hpp"
#include "cvode/solver.hpp"
#include "cvode/trajectory.hpp"
#include "dynamics/impact_events.hpp"
#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::cvode {

class Contacts {
 public:
  Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const CompliantContacts& compliant,
           const Options& options);

  bool any() const { return !pairs_.empty() || !held_.empty(); }
  // The plane of a ball at rest cancels the acceleration into it; `dydt` holds the rates of all forces.
  void hold(double* dydt) const;

  // A pair at its closest, without a contact.
  struct Passage {
    double t_s = 0;
    dynamics::ContactPair pair;
  };
  // The first instant in [from_s, to_s] at which a contact begins or ends; then `to_s` is this instant. A pair that is
  // apart: its gap falls to 0. Bodies that touch and neither approach nor separate: an overlap, or a gap, larger than
  // round-off, within which the gap changes its sign at every step. A ball at rest: the normal force falls to 0.
  // `rate` is that of all forces, without planes. Passages up to there are appended.
  using Rate = std::function<void(double t_s, const double* y, double* dydt)>;
  bool first_event(const Trajectory& path, const Reaches& reaches, const Rate& rate, double from_s, double& to_s,
                   std::vector<Passage>& passages);
  // Lets go balls whose normal force has ended, applies the impact laws to the pairs that touch and approach (coupled
  // contacts by the scene's convention) and brings balls to rest at the end of their bounces. Changes y; appends
  // events; fills `instant`. On failure() the instant has no state after it.
  void resolve(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
               dynamics::Instant<double>& instant);
  // Fills failure() when bodies overlap, or have left the plane they rest on, without an event, or where a ball that
  // rests begins to slide on a rough plane.
  void check(double t_s, const std::vector<double>& y, const Rate& rate);
  const std::string& failure() const { return failure_; }
  // The motion up to the instant of the failure is valid.
  bool valid_until_failure() const { return valid_until_failure_; }

 private:
  struct Pair : dynamics::ContactPair {
    bool in_contact = false;  // touches, and after an impact without rebound neither approaches nor separates
    double left_s = -1;       // when it last ceased to rest
    Watch gap{}, opening{};
  };
  struct Held : dynamics::ContactPair {  // a ball at rest on a plane
    std::array<double, 3> normal{};
    double least_drive_s = HUGE_VAL;  // the forces on the ball change slowly over shorter times
    bool constant = false;            // its normal force is
    double largest = 0;               // acceleration that the plane has cancelled: its round-off is that of the force
    bool leaves = false;              // at the event that has just been found
    Watch force{};
  };
  void find_gaps(Pair& pair, const Trajectory& path, const Reaches& reaches, double from_s, double& to_s, bool& any,
                 std::vector<Passage>& passages);
  void find_lift(Held& held, const Trajectory& path, const Rate& rate, double from_s, double& to_s, bool& any);
  void hold_ball(const dynamics::ContactPair& pair, const Real3& normal);
  void let_go(double t_s, const std::vector<double>& y, std::vector<Event>& events, dynamics::Instant<double>& instant);
  void undecided(const dynamics::ContactPair& pair, double t_s);
  double speed_tolerance(const Pair& pair, double gap_m, const std::vector<double>& y) const;
  // Sums the remaining bounces of a ball whose next bounce is lower than low_bounce_m_. False: there is nothing to sum,
  // or the case is not covered (failure()).
  bool bring_to_rest(const Pair& pair, double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                     dynamics::Instant<double>& instant);
  std::string name(int body) const { return "`" + scene_.bodies[body].name + "`"; }

  const Scene& scene_;
  dynamics::Dynamics<double>& equations_;
  const CompliantContacts& compliant_;
  double size_m_, low_bounce_m_, rtol_, atol_m_per_s_;
  std::vector<Pair> pairs_;
  std::vector<Held> held_;
  std::string failure_;
  bool valid_until_failure_ = false;
  dynamics::ImpactProgress<double> progress_;
};

}  // namespace atwood::cvode
