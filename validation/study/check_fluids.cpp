#include "validation/study/check_fluids.hpp"

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "scene/files.hpp"
#include "scene/fluid_surface.hpp"
#include "validation/metrics/fluid.hpp"

namespace atwood {
namespace {

// Fits of polynomials beside walls and free surfaces reach so much farther (docs/fluids.md, "Walls", "Free surface").
constexpr double kWidestFit = 1.4;

struct KernelFault {
  bool of_spacing = false;  // the kernel is too wide at this spacing
  std::string words;        // empty: there is no fault
};

bool has_free_surface(const Scene& scene) {
  try {
    return scene.fluids.size() == 1 && !surface_points(scene).empty();
  } catch (const std::invalid_argument&) {
    return false;  // the engine says why the surface is not known
  }
}

// Rounded down to 4 digits: a spacing of this value is admitted.
std::string at_most(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 3);
  return format_measure(std::floor(value / unit) * unit, 0, 4);
}

KernelFault wide_kernel(const Scene& scene, const Settings& settings, bool polynomial, bool open) {
  const double spacing = scene.fluids.front().spacing_m;
  const double widening = polynomial && (open || !scene.fluid_boundaries.empty()) ? kWidestFit : 1;
  const double support = widening * kernel_support_m(settings, spacing, open);
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(scene.domain.dimensions); ++axis) {
    const double period = scene.domain.periodic_m[axis];
    if (!(period > 0) || !(period < 2 * support)) continue;
    return {true, std::string(polynomial ? "the support of the fits" : "the kernel's support") + " is " +
                      format_measure(support, 0, 4) + " m at a spacing of " + format_measure(spacing, 0, 4) +
                      " m, more than half the period of " + format_measure(period, 0, 4) + " m along " + "xyz"[axis] +
                      ", so that a particle would have another as a neighbour twice; expected a spacing of at most " +
                      at_most(period / (2 * support) * spacing) + " m, or a smaller `smoothing`"};
  }
  return {};
}

KernelFault fault_of(const Scene& scene, const Worker& worker, const std::string& method) {
  const MethodId id = parse_method_id(method);
  if (scene.fluids.empty() || id.engine != "atwood" || worker.engine.name != "atwood") return {};
  const Settings settings = response_settings(worker, id);
  const auto degree = settings.find("degree");
  const bool polynomial = degree != settings.end(), open = polynomial && has_free_surface(scene);
  if (open && std::get<std::int64_t>(degree->second) == 4)
    return {false, "degree=4" + std::string(id.overrides.contains("degree") ? "" : ", the default,") +
                       " of +polynomial has no free surface, and the fluid `" + scene.fluids.front().name +
                       "` has one; expected degree=2"};
  return wide_kernel(scene, settings, polynomial, open);
}

std::string message(const std::string& who, const std::string& method, const Scenario& scenario,
                    const KernelFault& fault) {
  return who + method + " on `" + scenario.id + "`: " + fault.words;
}

}  // namespace

void check_fluids(const std::string& who, const std::vector<Cell>& cells, const std::vector<Worker>& workers) {
  std::map<std::pair<const Scenario*, std::string>, KernelFault> known;
  std::map<std::string, std::string> first_fault;  // by pattern of methods
  std::set<std::string> fits;                      // patterns
  for (const Cell& cell : cells) {
    if (cell.worker < 0 || cell.scenario->scene.fluids.empty()) continue;
    const auto [place, fresh] = known.try_emplace({cell.scenario.get(), cell.method});
    if (!fresh) continue;
    place->second = fault_of(cell.scenario->scene, workers[static_cast<std::size_t>(cell.worker)], cell.method);
    const KernelFault& fault = place->second;
    if (fault.words.empty()) {
      fits.insert(cell.pattern);
      continue;
    }
    const std::string words = message(who, cell.method, *cell.scenario, fault);
    const bool glob = cell.pattern.find_first_of("*?") != std::string::npos;
    if (!glob && fault.of_spacing) throw InputError(words);
    first_fault.try_emplace(cell.pattern, words);
  }
  for (const auto& [pattern, words] : first_fault)
    if (!fits.contains(pattern)) throw InputError(words);
}

void check_fluids(const std::string& who, const std::string& method, const Worker& worker, const Scenario& scenario) {
  const KernelFault fault = fault_of(scenario.scene, worker, method);
  if (!fault.words.empty()) throw InputError(message(who, method, scenario, fault));
}

}  // namespace atwood
