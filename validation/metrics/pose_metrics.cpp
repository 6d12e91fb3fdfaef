#include "validation/metrics/pose_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "scene/pair_sweep.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/order_statistics.hpp"

namespace atwood {
namespace {

// The largest coordinate of the pose [m], or along a swept path.
double extent_m(const Scene& scene, bool swept) {
  double extent = 0;
  for (const Body& body : scene.bodies) {
    for (std::size_t i = 0; i < 3; ++i) {
      extent = std::max(extent, std::fabs(body.position_m[i]));
      if (swept) extent = std::max(extent, std::fabs(body.position_m[i] + kSweepEndS * body.velocity_m_per_s[i]));
    }
    if (const auto* plane = std::get_if<Plane>(&body.shape)) extent = std::max(extent, std::fabs(plane->offset_m));
  }
  return extent + largest_radius_m(scene);
}

// The largest displacement of the surfaces by rounding the inputs: coordinates and sizes by the relative error u, an
// attitude by 2 u rad times the radius; summed over both bodies and three coordinates.
double moved_by_rounding_m(const Scene& scene, bool swept, const InputRounding& rounding) {
  if (rounding.unit == 0) return 0;
  double extent = extent_m(scene, swept);
  if (rounding.at_unit_size && !swept && scene.bodies.size() == 2) {
    const auto planar = [](const Body& body) { return std::holds_alternative<Plane>(body.shape); };
    double apart = 0;
    for (std::size_t i = 0; i < 3; ++i)
      apart = std::max(apart, std::fabs(scene.bodies[0].position_m[i] - scene.bodies[1].position_m[i]));
    if (!planar(scene.bodies[0]) && !planar(scene.bodies[1])) extent = apart + largest_radius_m(scene);
  }
  return 8 * rounding.unit * extent;
}

double closing_speed(const Scene& scene) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double v = scene.bodies[1].velocity_m_per_s[i] - scene.bodies[0].velocity_m_per_s[i];
    sum += v * v;
  }
  return std::sqrt(sum);
}

// The angle between two directions; a zero vector has no direction.
double angle(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double cross = 0, dot = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double c = a[j] * b[k] - a[k] * b[j];
    cross += c * c;
    dot += a[i] * b[i];
  }
  return cross == 0 && dot == 0 ? HUGE_VAL : std::atan2(std::sqrt(cross), dot);
}

// Whether both bodies are meshes of several triangles: they cross or are apart, but their depth is a convention of each
// engine.
bool surfaces(const Scene& scene) {
  return std::all_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& body) {
    const auto* mesh = std::get_if<Mesh>(&body.shape);
    return mesh && mesh->triangles.size() > 1;
  });
}

class Tally {
 public:
  Tally(std::string pair, PoseRows& out) : pair_(std::move(pair)), out_(out) {}

  void add(const std::string& what, std::int64_t index, double error, double bar = 0) {
    // NaN counts as an infinite error.
    errors_of(what).push_back({std::isnan(error) ? HUGE_VAL : error, index, bar});
  }
  void count(const std::string& metric, const std::string& what, std::size_t poses) {
    auto& list = errors_of(what);
    put(metric, static_cast<double>(list.size()), "of " + std::to_string(poses) + " poses");
    keep_worst(what, list);
  }
  // Median, 99th percentile and largest; no row where nothing was compared.
  void add_quantiles(const std::string& metric, const std::string& what, const std::string& unit_note) {
    auto& list = errors_of(what);
    if (list.empty()) return;
    std::sort(list.begin(), list.end(),
              [](const Error& a, const Error& b) { return std::pair(a.value, a.index) < std::pair(b.value, b.index); });
    const auto at = [&](double p) { return list[metrics::nearest_rank_index(list.size(), p)]; };
    const std::string reason = std::to_string(list.size()) + " poses" + unit_note;
    put(metric + "-median", at(0.5).value, reason, at(0.5).bar);
    put(metric + "-p99", at(0.99).value, reason, at(0.99).bar);
    put(metric + "-max", at(1).value, reason + "; the worst is pose " + std::to_string(list.back().index),
        bar_of_largest(list));
    keep_worst(what, list);
  }

 private:
  struct Error {
    double value = 0;
    std::int64_t index = 0;
    double bar = 0;
  };
  using Errors = std::vector<Error>;
  // Encloses [max(e - b), max(e + b)].
  static double bar_of_largest(const Errors& list) {
    double largest = 0, low = 0, high = 0;
    for (const Error& e : list) {
      largest = std::max(largest, e.value);
      low = std::max(low, e.value - e.bar);
      high = std::max(high, e.value + e.bar);
    }
    return std::isfinite(largest) ? std::max(largest - low, high - largest) : 0;
  }
  Errors& errors_of(const std::string& what) { return errors_[what]; }
  void put(const std::string& metric, double value, const std::string& reason, double bar = 0) {
    Row row = metrics::row(metric, value, bar, reason);
    row.body = pair_;
    out_.rows.push_back(row);
  }
  void keep_worst(const std::string& what, const Errors& list) {
    if (list.empty()) return;
    const auto worst = *std::max_element(list.begin(), list.end(), [](const Error& a, const Error& b) {
      return std::pair(a.value, a.index) < std::pair(b.value, b.index);
    });
    if (worst.value > 0) out_.worst.push_back({what, worst.index, worst.value});
  }

  std::string pair_;
  PoseRows& out_;
  std::map<std::string, Errors> errors_;
};

}  // namespace

PoseRows measure_poses(const std::string& pair, bool swept, const SceneOfPose& scene_of,
                       std::span<const PoseAnswer> answers, std::span<const PoseAnswer> truths,
                       const InputRounding& rounding) {
  PoseRows out;
  Tally tally(pair, out);
  const std::size_t poses = std::min(answers.size(), truths.size());
  for (std::size_t k = 0; k < poses; ++k) {
    const PoseAnswer &answer = answers[k], &truth = truths[k];
    const auto index = static_cast<std::int64_t>(k);
    const Scene scene = scene_of(index);
    const double size = pair_size_m(scene), extent = extent_m(scene, swept);
    const double moved = moved_by_rounding_m(scene, swept, rounding);
    if (swept) {
      if (truth.hit && !(truth.toi_s > 0))
        continue;  // they overlap at the start: shape casts are defined for separated bodies
      const double moved_s = moved > 0 ? std::min(kSweepEndS, moved / closing_speed(scene)) : 0;
      if (truth.hit && !answer.hit && kSweepEndS - truth.toi_s >= moved_s)
        tally.add("miss", index, kSweepEndS - truth.toi_s);
      if (!truth.hit && answer.hit) tally.add("false-hit", index, answer.toi_s);
      if (truth.hit && answer.hit) tally.add("time", index, std::fabs(answer.toi_s - truth.toi_s), moved_s);
      continue;
    }
    const double doubt = std::max({truth.bar, 64 * 0x1p-53 * extent, moved});
    const bool decided = std::fabs(truth.gap_m) > doubt;
    if (decided && truth.hit && !answer.hit) tally.add("miss", index, -truth.gap_m / size);
    if (decided && !truth.hit && answer.hit) tally.add("false-hit", index, truth.gap_m / size);
    if (truth.hit != answer.hit) continue;
    if (!truth.hit) {
      if (!std::isnan(answer.gap_m))
        tally.add("distance", index, std::fabs(answer.gap_m - truth.gap_m) / size, moved / size);
      continue;
    }
    if (surfaces(scene)) continue;
    tally.add("depth", index, std::fabs(answer.gap_m - truth.gap_m) / size, moved / size);
    const double needed = std::max({1e-3 * std::fabs(truth.gap_m), 1e-9 * size, 64 * doubt});
    if (decided && truth.margin_m > needed)
      tally.add("normal", index, angle(answer.normal, truth.normal), 8 * rounding.unit);
  }
  tally.count(swept ? "touch-misses" : "contact-misses", "miss", poses);
  tally.count(swept ? "touch-false-hits" : "contact-false-hits", "false-hit", poses);
  if (swept) {
    tally.add_quantiles("touch-time-error", "time", "");
  } else {
    tally.add_quantiles("contact-depth-error", "depth", ", relative to the smaller body");
    tally.add_quantiles("contact-normal-error", "normal", " with one direction of least depth");
    tally.add_quantiles("contact-distance-error", "distance", " apart, relative to the smaller body");
  }
  return out;
}

InputRounding input_rounding(const std::string& scalar, const std::string& test) {
  return {scalar == "float" ? 0x1p-24 : 0, test == "unit-size"};
}

std::vector<Row> over_all_pairs(std::span<const Row> rows) {
  std::vector<Row> whole;
  for (const Row& row : rows) {
    if (row.status != Status::ok || row.body.empty()) continue;
    const bool counted = row.metric.ends_with("-misses") || row.metric.ends_with("-hits");
    auto found = std::find_if(whole.begin(), whole.end(), [&](const Row& w) { return w.metric == row.metric; });
    if (found == whole.end()) {
      whole.push_back(row);
      whole.back().body.clear();
      whole.back().reason = counted ? "over all pairs" : "the worst pair is " + row.body;
    } else if (counted) {
      found->value += row.value;
    } else if (row.value > found->value) {
      found->value = row.value;
      found->truth_bar = row.truth_bar;
      found->reason = "the worst pair is " + row.body;
    }
  }
  return whole;
}

}  // namespace atwood
