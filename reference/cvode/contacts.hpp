// Contacts during a CVODE run: what touches, what bounces, what comes to rest. In double.
#pragma once

#include <string>
#include <vector>

#include "cvode/solver.hpp"
#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::cvode {

class Contacts {
 public:
  Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const Options& options);

  // Two root functions a pair. Apart: its gap, and minus the gap's rate, which falls through zero at the closest
  // approach: a ball may pass through another, a thin wall or a plane and out again within a step. Closing in on the
  // nearest approach CVODE's root finder meets the overlap, and goes on to the first root of the gap. Together: an
  // overlap, and a gap, beyond what round-off makes; within it the gap has a root at every step, and none of them is an
  // impact.
  int roots() const { return 2 * static_cast<int>(pairs_.size()); }
  void evaluate(const double* y, double* g) const;
  // Strikes what touches and approaches, by the scene's convention where several contacts act on each other; lays to
  // rest what bounces no more. Returns whether anything changed, and tells what happened.
  bool settle(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
              dynamics::Instant<double>& told);
  // Pairs at their nearest: the gap's rate is zero there.
  std::vector<dynamics::ContactPair> passed(const std::vector<double>& y) const;
  // Have bodies got into each other, or left a plane that they rest on, unseen by the roots?
  void check(const std::vector<double>& y);
  const std::string& failure() const { return failure_; }
  // The failure is that of its instant: up to it all is well.
  bool branch() const { return branch_; }

 private:
  struct Pair : dynamics::ContactPair {
    bool together = false;  // touches, and after an impact without rebound neither approaches nor leaves
  };
  double slow(const Pair& pair, double gap_m, const std::vector<double>& y) const;
  bool may_strike(const dynamics::ContactPair& pair, double t_s, const std::vector<double>& y);
  void tell(const dynamics::Blow<double>& blow, const double* after, double t_s, std::vector<Event>& events) const;
  void advances(double t_s);
  bool rests(const Pair& pair, double t_s, std::vector<double>& y, int interval, std::vector<Event>& events,
             dynamics::Instant<double>& told);
  std::string name(int body) const { return "`" + scene_.bodies[body].name + "`"; }

  const Scene& scene_;
  dynamics::Dynamics<double>& equations_;
  double size_m_, low_bounce_m_, rtol_, atol_m_per_s_;
  std::vector<Pair> pairs_, held_;
  std::string failure_;
  bool branch_ = false;
  double last_strike_s_ = -1;
  int stalled_ = 0;
};

}  // namespace atwood::cvode
