// Further queries of a pair of bodies besides Engine::contacts, and the answer to a sweep of seeded poses.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "protocol/contact_query.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Closest points of two bodies, or the deepest ones.
struct PairGap {
  Wide gap_m = 0;                       // signed: negative is the depth of least penetration
  std::array<Wide, 3> normal{}, x_m{};  // unit, from a to b; the point midway between the two
  double bar_m = 0;                     // half-width of gap_m: of a truth
  // For a truth: difference to the gap along the next direction; 0: the direction is not unique.
  double margin_m = 0;
};

struct PairQueries {
  // Throws std::invalid_argument with the pair of shapes that is not covered.
  std::function<PairGap(const Scene&, int a, int b)> gap = {};
  bool gap_decides = false;  // a truth whose sign of gap_m decides whether two bodies overlap
  // Tests beside the engine's own contacts, by name.
  std::map<std::string, std::function<ContactAnswer(const Scene&, const ContactQuery&)>> tests = {};
};

// One pose of a sweep (scene/pair_sweep.hpp).
struct PoseAnswer {
  bool hit = false;  // swept: they touch within the sweep
  double gap_m = std::numeric_limits<
      double>::quiet_NaN();               // as above; NaN: separated, at a distance that the engine does not compute
  double toi_s = 0;                       // swept
  std::array<double, 3> normal{}, x_m{};  // of the deepest contact
  int points = 0;                         // of all contacts
  double bar = 0, margin_m = 0;           // of a truth; bar of gap_m, or of toi_s
};

}  // namespace atwood
