#include "dart/surfaces.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::dartsim {
namespace {

constexpr double kTakenForNone = 1e-3;  // DART's own thresholds, of restitution and of friction

bool too_small(double coefficient) { return coefficient > 0 && coefficient <= kTakenForNone; }

}  // namespace

std::vector<Surface> surfaces_of(int material, const std::vector<PairLaw>& laws) {
  if (laws.empty()) return {};
  const PairLaw& first = laws.front();
  const bool one_law = std::all_of(laws.begin(), laws.end(), [&](const PairLaw& law) {
    return law.restitution == first.restitution && law.friction == first.friction;
  });
  if (one_law) return {{-1, std::sqrt(first.restitution), first.friction}};
  std::vector<Surface> all;
  for (const auto& law : laws) {
    if (law.a != material && law.b != material) continue;
    // For two materials the first has the restitution and the second 1; for one material both have its square root.
    const double share = law.a == law.b ? std::sqrt(law.restitution) : law.a == material ? law.restitution : 1.0;
    all.push_back({law.a == material ? law.b : law.a, share, law.friction});
  }
  return all;
}

std::string refused_law(const std::vector<PairLaw>& laws) {
  for (const auto& law : laws) {
    if (law.rolling_friction_m != 0) return "DART has no rolling friction";
    if (too_small(law.restitution)) return "DART treats a restitution of 0.001 or less as zero; found one above 0";
    if (too_small(law.friction))
      return "DART treats a friction coefficient of 0.001 or less as zero; found one above 0";
  }
  return "";
}

}  // namespace atwood::dartsim
