// A truth: samples with a half-width (bar) for every value, and their source.
#pragma once

#include <string>
#include <vector>

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood {

struct Truth {
  std::string source;   // "closed form: <citation>", "extended: GBS 24 and Gauss 20", "cvode: ..."
  SampleSeries values;  // samples + 1 of them; fewer when the truth ends at a time given in the reason
  SampleSeries bars;    // same layout: half-width of every value (q: of each component); 0 at t = 0
  std::vector<Event> events;
  std::vector<double> event_bar_s;  // half-width of each event's time
  double condition = 0;             // largest growth of a relative perturbation of the initial state; 0: not computed
  std::string note;  // why a bar is wider than 1e-20 of the scale, and from which time on values are not bounded
  Outcome outcome;   // not ok: the reason says why; values, if any, are those certified before
};

using TruthSolver = Truth (*)(const Scenario&, std::int64_t samples);

}  // namespace atwood
