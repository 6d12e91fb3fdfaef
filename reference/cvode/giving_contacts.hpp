// Contacts that give way during a CVODE run: forces along the line of touch, switched at roots. In double; no friction.
#pragma once

#include <string>
#include <vector>

#include "dynamics/contacts.hpp"

namespace atwood::cvode {

// Pairs whose materials have a contact law: linear F = k d + c d', Hertz F = K d^(3/2) (1 + a d'), K = 4/3 E sqrt(R).
// Each is
//   apart    until the gap falls to 0
//   pressed  until the gap is 0 again, or (unless it may pull) the force is
//   spent    overlapping without force, until the gap is 0 or the force grows again
// and the equations are smooth within each.
class GivingContacts {
 public:
  GivingContacts(const Scene& scene, const dynamics::Layout& layout);

  const std::string& failure() const { return failure_; }
  bool any() const { return !pairs_.empty(); }
  // The modes that hold at y: at the start, and after every root.
  void settle(const double* y);
  void add_rates(const double* y, double* dydt) const;
  int roots() const { return 2 * static_cast<int>(pairs_.size()); }
  void evaluate(const double* y, double* g) const;

 private:
  enum class Mode : unsigned char { apart, pressed, spent };
  struct Pair {
    dynamics::ContactPair bodies;
    const PairLaw* law = nullptr;
    double hertz_N_per_m32 = 0;  // K
    Mode mode = Mode::apart;
  };
  double force(const Pair& pair, const dynamics::Gap<double>& gap) const;

  const Scene& scene_;
  const dynamics::Layout& layout_;
  double tiny_m_ = 0;  // a gap that the location of a root leaves
  std::vector<Pair> pairs_;
  std::string failure_;
};

}  // namespace atwood::cvode
