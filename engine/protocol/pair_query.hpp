// What a worker can tell of a pair of bodies besides Engine::contacts, and how it answers a sweep of seeded poses.
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
  // Of a truth: how far the next direction's gap is behind this one's; 0 where the direction is not unique.
  double margin_m = 0;
};

struct PairQueries {
  // Throws std::invalid_argument: what it has no test for.
  std::function<PairGap(const Scene&, int a, int b)> gap = {};
  bool gap_decides = false;  // a truth: whether two bodies overlap is its sign, bars and all
  // Tests beside the engine's own contacts, by name.
  std::map<std::string, std::function<ContactAnswer(const Scene&, const ContactQuery&)>> tests = {};
};

// One pose of a sweep (scene/pair_sweep.hpp).
struct PoseAnswer {
  bool hit = false;  // swept: they touch within the sweep
  double gap_m =
      std::numeric_limits<double>::quiet_NaN();  // as above; NaN: apart, and the engine does not tell how far
  double toi_s = 0;                              // swept
  std::array<double, 3> normal{}, x_m{};         // of the deepest contact
  int points = 0;                                // of all contacts
  double bar = 0, margin_m = 0;                  // of a truth; bar of gap_m, or of toi_s
};

}  // namespace atwood
