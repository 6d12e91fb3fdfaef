// The probes by name, and what each measures.
#include "validation/metrics/probes.hpp"

namespace atwood {

const std::vector<ProbeInfo>& all_probes() {
  static const std::vector<ProbeInfo> probes = {
      {Probe::ensemble, "ensemble",
       "96 runs, each nonzero initial coordinate moved in the last place (by more than one unit where few coordinates "
       "are nonzero), beside the same runs in wider "
       "arithmetic: the law by which round-off grows. Unsupported for methods without wider arithmetic (all other "
       "engines', and @quad)."},
      {Probe::reversal, "reversal",
       "To the end, velocities reversed, the same number of steps back: the distance from the start."},
      {Probe::symplecticity, "symplecticity",
       "The end state's derivatives with respect to the initial canonical variables: |M^T J M - J|."},
      {Probe::lyapunov, "lyapunov",
       "Two runs that start 1e-10 of the scale apart: the predictability horizon and the exponent of their separation."},
      {Probe::determinism, "determinism",
       "The run repeated, and repeated by 1, 2, 4 and 16 threads where the method names a number of threads: how many "
       "numbers differ in any bit, and a hash of the end state."},
      {Probe::round_off_v, "round-off-v",
       "The ladder in float, double and long double, with and without compensated summation: the step of least error."},
      {Probe::tolerance, "tolerance",
       "Tolerances from 1e-3 to 1e-12: error over tolerance, and how the error follows it."},
      {Probe::contact_sweep, "contact-sweep",
       "Contacts of seeded poses, `steps` of them a pair of shapes, against the exact ones: misses, false hits, depth, "
       "normal."},
      {Probe::touch_sweep, "touch-sweep",
       "First touches of seeded motions, `steps` of them a pair of shapes, against the exact ones: misses, time."},
      {Probe::contact_tables, "contact-tables",
       "Contacts of the cases in the folder `geometry` beside the scenario, whose answers are derived by hand."}};
  return probes;
}

std::string to_string(Probe probe) {
  for (const ProbeInfo& info : all_probes())
    if (info.probe == probe) return info.name;
  return "";
}

std::optional<Probe> find_probe(const std::string& name) {
  for (const ProbeInfo& info : all_probes())
    if (info.name == name) return info.probe;
  return std::nullopt;
}

}  // namespace atwood
