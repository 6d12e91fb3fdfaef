// J. C. Martin and W. J. Moyce, Part IV: An experimental study of the collapse of liquid columns on a rigid horizontal
// plane, Phil. Trans. R. Soc. Lond. A 244 (1952) 312, table 2: water, a square base of a = 2.25 inches, height n^2 a
// with n^2 = 2.
//   Z = z / a, z from the back of the column to the front;   T = n t sqrt(g / a)
// The figures were read from a film; readings of the table and of figure 3 differ by up to 2 %, repeated columns by
// some 5 %, which is the band. The start is that of the measurement: the column was released by a diaphragm, and the
// first figure may be late by a time that is common to all (a delay).
#include "fluid_truth/literature.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "fluid_truth/solution.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

using namespace fluid_truth;

namespace {

struct Reading {
  double T, Z;
};
constexpr Reading kFront[] = {{0.41, 1.11}, {0.84, 1.22}, {1.19, 1.44}, {1.43, 1.67}, {1.63, 1.89},
                              {1.83, 2.11}, {1.98, 2.33}, {2.20, 2.56}, {2.32, 2.78}, {2.51, 3.00},
                              {2.65, 3.22}, {2.83, 3.44}, {2.97, 3.67}, {3.11, 3.89}, {3.33, 4.11},
                              {4.02, 5.00}, {4.44, 6.00}, {5.09, 7.00}, {5.69, 8.00}, {6.30, 9.00},
                              {6.83, 10.0}, {7.44, 11.0}, {8.07, 12.0}, {8.67, 13.0}, {9.31, 14.0}};
constexpr double kBand = 0.05;

// Linear between the readings.
std::optional<double> front_at(double T) {
  const auto after = std::lower_bound(std::begin(kFront), std::end(kFront), T,
                                      [](const Reading& reading, double time) { return reading.T < time; });
  if (after == std::end(kFront) || T < kFront[0].T) return {};
  if (after->T == T) return after->Z;
  const Reading &b = *after, &a = *(after - 1);
  return a.Z + (b.Z - a.Z) * (T - a.T) / (b.T - a.T);
}

}  // namespace

FluidField literature_field(const Scenario& given) {
  FluidField made;
  try {
    require(given.truth.solution == "martin-moyce",
            "no such published values: expected martin-moyce; found `" + given.truth.solution + "`");
    const Fluid& fluid = only_fluid(given.scene);
    const Upwards up = upwards_of(given.scene);
    const auto* box = std::get_if<BoxRegion>(&fluid.region);
    require(box != nullptr && up.axis != 0, "expected the region of a box and gravity across x");
    const double back = box->min_m[0], a = box->max_m[0] - back, height = box->max_m[up.axis] - box->min_m[up.axis];
    require(back == 0, "expected the back of the column at x = 0, from where the front is measured");
    require(a > 0 && std::fabs(height - 2 * a) <= 1e-9 * a, "expected a column twice as high as wide (n^2 = 2)");
    const double rate = std::sqrt(2 * up.g / a);
    made.source = "Martin and Moyce, Phil. Trans. R. Soc. Lond. A 244 (1952) 312, table 2";
    made.note = "read from a film: a band of 5 % of the front's distance from the back; the start may be delayed";
    made.at = [=, probes = given.scene.probes](Wide t_s, const std::vector<FieldPosition>& positions) {
      FieldSample sample;
      sample.t_s = t_s;
      const Wide infinite = std::numeric_limits<double>::infinity();
      for (const FieldPosition& x : positions) {
        sample.values.push_back({x, {}, 0, 0, 0});
        sample.bars.push_back({{}, {infinite, infinite, infinite}, infinite, infinite, infinite});
      }
      for (const FluidProbe& probe : probes) {
        auto& to = sample.probes.emplace_back();
        const auto Z = front_at(static_cast<double>(t_s) * rate);
        if (probe.kind == ProbeKind::front && Z) to = ProbeValue{back + a * *Z, kBand * a * *Z};
      }
      return sample;
    };
  } catch (const Refused& refusal) {
    made.outcome = refused("literature: " + refusal.why);
  }
  return made;
}

}  // namespace atwood
