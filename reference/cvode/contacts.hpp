// Rigid contacts during a CVODE run: root functions, impacts, balls that come to rest. In double.
#pragma once

#include <string>
#include <vector>

#include "cvode/solver.hpp"
#include "dynamics/impact_events.hpp"
#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::cvode {

class Contacts {
 public:
  Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const Options& options);

  // Two root functions per pair; a root is where one falls through zero.
  // Separated: the gap, and minus the rate of the gap, which falls through zero at the closest approach. The second one
  // is there because a ball may enter another, a thin wall or a plane and leave it again within one step: while CVODE
  // locates the closest approach it meets the overlap and continues to the first root of the gap.
  // In contact: an overlap, and a gap, larger than round-off. Within round-off the gap changes its sign at every step
  // without an impact.
  int roots() const { return 2 * static_cast<int>(pairs_.size()); }
  void evaluate(const double* y, double* g) const;
  // Applies the impact laws to the pairs that touch and approach (coupled contacts by the scene's convention) and
  // brings balls to rest at the end of their bounces. Changes y; appends events; fills `instant`. True: y or the root
  // functions changed, so that the integration must be restarted. On failure() the instant has no state after it.
  bool resolve(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
               dynamics::Instant<double>& instant);
  // Pairs at their closest approach: the rate of their gap is zero at y.
  std::vector<dynamics::ContactPair> closest_approaches(const std::vector<double>& y) const;
  // Fills failure() when bodies overlap, or have left the plane they rest on, without a root.
  void check_penetration(double t_s, const std::vector<double>& y);
  const std::string& failure() const { return failure_; }
  // The motion up to the instant of the failure is valid.
  bool valid_until_failure() const { return valid_until_failure_; }

 private:
  struct Pair : dynamics::ContactPair {
    bool in_contact = false;  // touches, and after an impact without rebound neither approaches nor separates
  };
  double speed_tolerance(const Pair& pair, double gap_m, const std::vector<double>& y) const;
  // Sums the remaining bounces of a ball whose next bounce is lower than low_bounce_m_. False: there is nothing to sum,
  // or the case is not covered (failure()).
  bool bring_to_rest(const Pair& pair, double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
                     dynamics::Instant<double>& instant);
  std::string name(int body) const { return "`" + scene_.bodies[body].name + "`"; }

  const Scene& scene_;
  dynamics::Dynamics<double>& equations_;
  double size_m_, low_bounce_m_, rtol_, speed_m_per_s_, atol_m_per_s_;
  std::vector<Pair> pairs_;
  std::vector<dynamics::ContactPair> held_;  // balls at rest on a plane
  std::string failure_;
  bool valid_until_failure_ = false;
  dynamics::ImpactProgress<double> progress_;
};

}  // namespace atwood::cvode
