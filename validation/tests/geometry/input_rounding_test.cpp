// An engine in float answers the pose that it was given, rounded to float.
#include <catch2/catch.hpp>

#include <cmath>

#include "validation/metrics/pose_metrics.hpp"

using namespace atwood;

namespace {

// Two balls of 1 mm, `depth_m` deep along x, `far_m` from the origin.
Scene balls(double far_m, double depth_m) {
  Scene scene;
  for (const double at : {0.0, 2e-3 - depth_m}) {
    Body body;
    body.name = at == 0 ? "a" : "b";
    body.mass_kg = 1;
    body.shape = Sphere{1e-3};
    body.position_m = {far_m + at, far_m, 0};
    scene.bodies.push_back(body);
  }
  return scene;
}

// Exact geometry of the doubles, and of the floats closest to them.
PoseAnswer answer(const Scene& scene, bool in_float) {
  double d[3], sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double a = scene.bodies[0].position_m[k], b = scene.bodies[1].position_m[k];
    d[k] = in_float ? static_cast<double>(static_cast<float>(b)) - static_cast<double>(static_cast<float>(a)) : b - a;
    sum += d[k] * d[k];
  }
  PoseAnswer pose;
  pose.gap_m = std::sqrt(sum) - 2e-3;
  pose.hit = pose.gap_m <= 0;
  for (int k = 0; k < 3; ++k) pose.normal[k] = d[k] / std::sqrt(sum);
  pose.margin_m = HUGE_VAL;
  return pose;
}

const Row& row_of(const PoseRows& made, const std::string& metric) {
  for (const Row& row : made.rows)
    if (row.metric == metric) return row;
  FAIL("no row " << metric);
  return made.rows.front();
}

PoseRows measured(double far_m, double depth_m, const std::string& scalar, const std::string& test) {
  const Scene scene = balls(far_m, depth_m);
  const std::vector<PoseAnswer> found{answer(scene, scalar == "float")}, truth{answer(scene, false)};
  return measure_poses(
      "sphere-sphere", false, [&](std::int64_t) { return scene; }, found, truth, input_rounding(scalar, test));
}

}  // namespace

TEST_CASE("rounding a pose to float gives the bar of the figures of a float engine and is not its error") {
  // At 300.0007 m a float's neighbours are 3e-5 m apart: of a depth of 1e-3 m a few hundredths are lost.
  const PoseRows far = measured(300.0007, 1e-3, "float", "contacts");
  const Row& depth = row_of(far, "contact-depth-error-max");
  CHECK(depth.value > 1e-3);
  CHECK(depth.value <= depth.truth_bar);
  CHECK(depth.truth_bar < 1);
  // 1e-6 m deep: the floats are apart. Nobody who is given floats can tell.
  const Scene shallow = balls(300.0007, 1e-6);
  PoseAnswer apart = answer(shallow, false);
  apart.hit = false, apart.gap_m = 1e-6;
  const auto misses = [&](const std::string& scalar, const std::string& test) {
    const std::vector<PoseAnswer> found{apart}, truth{answer(shallow, false)};
    return row_of(measure_poses(
                      "sphere-sphere", false, [&](std::int64_t) { return shallow; }, found, truth,
                      input_rounding(scalar, test)),
                  "contact-misses")
        .value;
  };
  CHECK(misses("float", "contacts") == 0);
  CHECK(misses("float", "unit-size") == 1);  // moved to the origin before it is rounded: it could have been seen
  CHECK(misses("double", "contacts") == 1);
}

TEST_CASE("near the origin, and in double, the bar forgives next to nothing") {
  CHECK(row_of(measured(0, 1e-3, "float", "contacts"), "contact-depth-error-max").truth_bar < 1e-5);
  CHECK(row_of(measured(300.0007, 1e-3, "double", "contacts"), "contact-depth-error-max").truth_bar == 0);
}
