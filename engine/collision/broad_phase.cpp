#include "collision/broad_phase.hpp"

#include <stdexcept>

#include "collision/broad_kinds.hpp"

namespace atwood {

const std::vector<std::string>& broad_phase_names() {
  static const std::vector<std::string> names{"all-pairs", "manhattan", "bounding-spheres", "sweep-and-prune", "grid",
                                              "tree",      "bsp"};
  return names;
}

BroadPhaseKind broad_phase_kind(const std::string& name) {
  const std::vector<std::string>& names = broad_phase_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<BroadPhaseKind>(found - names.begin());
  std::string known;
  for (const std::string& each : names) known += (known.empty() ? "" : ", ") + each;
  throw std::invalid_argument("found the broad phase `" + name + "`; expected one of " + known);
}

template <class S> std::unique_ptr<BroadPhase<S>> make_broad_phase(BroadPhaseKind kind, Team* team) {
  switch (kind) {
    case BroadPhaseKind::all_pairs: return broad::make_all_pairs<S>();
    case BroadPhaseKind::manhattan: return broad::make_manhattan<S>();
    case BroadPhaseKind::bounding_spheres: return broad::make_bounding_spheres<S>();
    case BroadPhaseKind::sweep_and_prune: return broad::make_sweep_and_prune<S>();
    case BroadPhaseKind::grid: return broad::make_grid<S>(team);
    case BroadPhaseKind::tree: return broad::make_tree<S>(team);
    case BroadPhaseKind::bsp: return broad::make_bsp<S>();
  }
  throw std::invalid_argument("no such broad phase");
}

template std::unique_ptr<BroadPhase<float>> make_broad_phase(BroadPhaseKind, Team*);
template std::unique_ptr<BroadPhase<double>> make_broad_phase(BroadPhaseKind, Team*);

namespace broad {

void PairSort::sort(const std::vector<BodyPair>& found, std::size_t count, std::vector<BodyPair>& pairs) {
  start_.assign(count + 1, 0);
  pairs.resize(found.size());
  for (const BodyPair& pair : found) ++start_[static_cast<std::size_t>(pair.first) + 1];
  for (std::size_t i = 0; i < count; ++i) start_[i + 1] += start_[i];
  for (const BodyPair& pair : found)
    pairs[static_cast<std::size_t>(start_[static_cast<std::size_t>(pair.first)]++)] = pair;
  // start_[i] is now where i's partners end
  std::int32_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t end = start_[i];
    if (end - begin > 1)
      std::sort(pairs.begin() + begin, pairs.begin() + end,
                [](const BodyPair& a, const BodyPair& b) { return a.second < b.second; });
    begin = end;
  }
}

}  // namespace broad
}  // namespace atwood
