#include "reports/command_line/joint_question.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "dynamics/joint_poses.hpp"
#include "scene/files.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr const char* kBoth = "error-joint-coordinate";
constexpr const char* kAngles = "error-joint-angle";
constexpr const char* kOffsets = "error-joint-offset";

// The metric of the coordinates that `metric` leaves out; empty: it leaves none out.
std::string other_metric(const std::string& metric) {
  return metric == kAngles ? kOffsets : metric == kOffsets ? kAngles : "";
}

std::string left_out(const std::string& metric) { return metric == kAngles ? "offsets" : "angles"; }

}  // namespace

void require_coordinates(const Scenario& scenario, const std::string& metric, const std::string& asked) {
  if (metric != kBoth && metric != kAngles && metric != kOffsets) return;
  for (const Joint& joint : scenario.scene.joints) {
    if (joint.driven_rate) continue;
    if (joint.kind == JointKind::ball && metric != kOffsets) return;
    for (int i = 0; i < coordinate_count(joint.kind); ++i)
      if (metric == kBoth || (metric == kAngles) == dynamics::is_angle(joint.kind, i)) return;
  }
  throw InputError(fmt::format("--metric {}: no joint of `{}` has {} that is not prescribed", asked, scenario.id,
                               metric == kBoth     ? "a coordinate"
                               : metric == kAngles ? "an angle"
                                                   : "an offset"));
}

std::string joint_unit(std::span<const Row> rows, const std::string& metric) {
  if (metric != kBoth) return "";
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.metric == metric && r.body.empty(); });
  return row == rows.end() ? "" : row->unit;
}

std::string unjudged_coordinates(std::span<const Row> rows, const std::string& metric, const std::string& method,
                                 std::int64_t steps) {
  const std::string other = other_metric(metric);
  if (other.empty()) return "";
  for (const Row& row : rows) {
    if (row.metric == other && row.method == method && row.steps == steps)
      return fmt::format("{} of joints; their error in this run is {} {} (--error without a unit judges both)",
                         left_out(metric), format_measure(row.value, row.truth_bar, 3), row.unit);
  }
  return "";
}

std::string unjudged_note(std::span<const Row> rows, const std::string& metric, const std::string& scenario) {
  const std::string other = other_metric(metric);
  if (other.empty()) return "";
  const Row *least = nullptr, *most = nullptr;
  for (const Row& row : rows) {
    if (row.scenario != scenario || row.metric != other || !std::isfinite(row.value)) continue;
    if (least == nullptr || row.value < least->value) least = &row;
    if (most == nullptr || row.value > most->value) most = &row;
  }
  if (least == nullptr) return "";
  return fmt::format(
      "{}: {} of joints are not judged; their errors in these runs: {} to {} {} (--error without a unit "
      "judges both)",
      scenario, left_out(metric), format_measure(least->value, least->truth_bar, 3),
      format_measure(most->value, most->truth_bar, 3), most->unit);
}

}  // namespace atwood
