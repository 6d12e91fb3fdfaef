// Contacts during a CVODE run: what touches, what bounces, what comes to rest. In double.
#pragma once

#include <string>
#include <vector>

#include "cvode/solver.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/rates.hpp"

namespace atwood::cvode {

class Contacts {
 public:
  Contacts(const Scene& scene, dynamics::Dynamics<double>& equations, const Options& options);

  // Root functions: the gap of every pair, then, falling through zero at the closest approach, minus the gap's rate of
  // every pair without a plane: a ball may pass through another or a thin wall and out again within a step. Closing in on the nearest approach
  // CVODE's root finder meets the overlap, and goes on to the first root of the gap.
  int roots() const;
  void evaluate(const double* y, double* g) const;
  // Strikes what touches and approaches, lays to rest what bounces no more. Returns whether anything changed.
  bool settle(double t_s, std::vector<double>& y, int interval, std::vector<Event>& events);
  void check_held(const std::vector<double>& y);
  const std::string& failure() const { return failure_; }

 private:
  void strike(const dynamics::ContactPair& pair, double t_s, std::vector<double>& y, std::vector<Event>& events);
  bool rests(const dynamics::ContactPair& pair, double t_s, std::vector<double>& y, int interval,
             std::vector<Event>& events);
  std::string name(int body) const { return "`" + scene_.bodies[body].name + "`"; }

  const Scene& scene_;
  dynamics::Dynamics<double>& equations_;
  double size_m_, low_bounce_m_;
  std::vector<dynamics::ContactPair> pairs_, held_;
  std::string failure_;
  int strikes_ = 0;
};

}  // namespace atwood::cvode
