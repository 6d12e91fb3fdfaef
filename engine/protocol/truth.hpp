// What a truth is: samples with a bar on every value, and where they come from.
#pragma once

#include <string>
#include <vector>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood {

struct Truth {
  std::string source;          // "closed form: <citation>", "extended: GBS 24 and Gauss 20", "cvode: ..."
  std::vector<Sample> values;  // samples + 1 of them; fewer where the truth ends at an instant that the reason names
  std::vector<Sample> bars;    // same layout: half-width of every value (q: of each component); 0 at t = 0
  std::vector<Event> events;
  std::vector<double> event_bar_s;  // half-width of each event's time
  double condition = 0;             // largest growth of a relative perturbation of the initial state; 0: not computed
  std::string note;  // why a bar is wider than 1e-20 of the scale, if it is, and from when on nothing is bounded
  Outcome outcome;   // not ok: the reason says why; values, if any, are those certified before
};

using TruthSolver = Truth (*)(const Scenario&, std::int64_t samples);

}  // namespace atwood
