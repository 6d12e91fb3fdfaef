// Compliant contacts during a CVODE run: normal forces that are switched at zeros. In double; without friction.
#pragma once

#include <string>
#include <vector>

#include "cvode/trajectory.hpp"
#include "dynamics/contacts.hpp"

namespace atwood::cvode {

// Pairs whose materials have a compliant contact law, with the overlap d = -gap [m] and the force F [N]:
//   linear  F = k d + c d'
//   Hertz   F = K d^(3/2) (1 + a d'),  K = 4/3 E sqrt(R),  1/R = 1/r_a + 1/r_b   (K. L. Johnson, Contact Mechanics,
//           1985, section 4.2; damping: K. H. Hunt and F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440)
// Each pair is in one of three modes, and the equations are smooth within each:
//   separated  until the gap falls to 0
//   loaded     until the gap is 0 again, or, unless the law may pull, until F falls to 0
//   unloaded   overlapping without force, until the gap is 0 or F would be positive again
class CompliantContacts {
 public:
  CompliantContacts(const Scene& scene, const dynamics::Layout& layout);

  // Not empty: a pair has friction, which is not covered.
  const std::string& failure() const { return failure_; }
  bool any() const { return !pairs_.empty(); }
  // Determines the modes at y; called at the start and after every event.
  void update_modes(const double* y);
  void add_rates(const double* y, double* dydt) const;
  // Does a contact press on the body?
  bool presses_on(int body) const;
  // The first instant in [from_s, to_s] at which a mode ends; then `to_s` is this instant.
  bool first_event(const Trajectory& path, const Reaches& reaches, double from_s, double& to_s);

 private:
  enum class Mode : unsigned char { separated, loaded, unloaded };
  struct Pair {
    dynamics::ContactPair bodies;
    const PairLaw* law = nullptr;
    double hertz_N_per_m32 = 0;  // K
    Mode mode = Mode::separated;
    Watch gap{}, force{};
  };
  double force(const Pair& pair, const dynamics::Gap<double>& gap) const;
  double sign_of_force(const Pair& pair, const dynamics::Gap<double>& gap) const;
  double force_round_off(const Pair& pair) const;
  bool damped(const Pair& pair) const;

  const Scene& scene_;
  const dynamics::Layout& layout_;
  double gap_tolerance_m_ = 0;  // |gap| at a located root
  std::vector<Pair> pairs_;
  std::string failure_;
};

}  // namespace atwood::cvode
