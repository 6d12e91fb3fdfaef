// Compensated summation lowers the floor of the round-off V: the least error that any step size reaches.
#include <catch2/catch.hpp>

#include "scenes.hpp"

namespace atwood::testing {
namespace {

BodySample end_of(const std::string& scheme, const std::string& scalar, bool compensated, const Scene& scene,
                  double t_end_s, std::int64_t steps) {
  MethodId id;
  id.engine = "atwood";
  id.scheme = scheme;
  id.scalar = scalar;
  if (compensated) id.overrides["compensated"] = true;
  BodySample last;
  Observer observer;
  observer.sample = [&](const Sample& sample) { last = sample.bodies[0]; };
  const Outcome outcome = atwood_engine().run(id, scene, {t_end_s, steps, 1}, observer, 0);
  REQUIRE(outcome.status == Status::ok);
  return last;
}

double position_error(const BodySample& a, const BodySample& b) { return distance(a.p_m, b.p_m); }
double attitude_error(const BodySample& a, const BodySample& b) { return attitude_distance(a.q_wxyz, b.q_wxyz); }
double body_rate_error(const BodySample& a, const BodySample& b) { return distance(a.w_rad_per_s, b.w_rad_per_s); }
using Error = double (*)(const BodySample&, const BodySample&);

struct V {
  double plain = 1e9, compensated = 1e9;
};
V floors(const std::string& scheme, const std::string& scalar, const Scene& scene, double t_end_s, std::int64_t finest,
         Error error, const BodySample& truth) {
  V v;
  for (int k = 0; k < 6; ++k) {
    v.plain = std::min(v.plain, error(end_of(scheme, scalar, false, scene, t_end_s, finest >> k), truth));
    v.compensated = std::min(v.compensated, error(end_of(scheme, scalar, true, scene, t_end_s, finest >> k), truth));
  }
  return v;
}

void check_lowered(const V& v, double times) {
  INFO("least error " << v.plain << ", compensated " << v.compensated);
  CHECK(v.compensated * times < v.plain);
  CHECK(v.compensated > 0);
}

TEST_CASE("compensation lowers the floor on an orbit") {
  const BodySample truth = end_of("verner9", "quad", false, kepler(0.6), 10, 4000);
  struct Case {
    const char *scheme, *scalar;
    std::int64_t finest;
    double times;
  };
  for (const auto& [scheme, scalar, finest, times] :
       {Case{"rk4", "float", 32768, 5}, Case{"rk4", "double", 262144, 10}, Case{"rk38", "double", 262144, 10},
        Case{"dopri5", "double", 65536, 5}, Case{"dop853", "double", 16384, 3}, Case{"dprkn6", "float", 8192, 3},
        Case{"dprkn6", "double", 32768, 3}, Case{"blanes-moan-rkn4", "float", 16384, 3},
        Case{"blanes-moan-rkn6", "double", 32768, 3}}) {
    INFO(scheme << " in " << scalar);
    check_lowered(floors(scheme, scalar, kepler(0.6), 10, finest, position_error, truth), times);
  }
}

TEST_CASE("compensation lowers the floor on a body that rotates") {
  const BodySample truth = end_of("verner9", "quad", false, free_box(false), 10, 8000);
  struct Case {
    const char *scheme, *scalar;
    std::int64_t finest;
    double times;
  };
  for (const auto& [scheme, scalar, finest, times] :
       {Case{"rk4", "float", 65536, 20}, Case{"rk4", "double", 262144, 100}, Case{"dopri5", "double", 65536, 50}}) {
    INFO(scheme << " in " << scalar);
    check_lowered(floors(scheme, scalar, free_box(false), 10, finest, attitude_error, truth), times);
    check_lowered(floors(scheme, scalar, free_box(false), 10, finest, body_rate_error, truth), times);
  }
}

// A ball keeps its rate: the attitude's error is what its own sums and normalisation round off. To overwrite the
// quaternion by its normalised self would throw the rest away each time.
TEST_CASE("with compensation an attitude ends within a unit in the last place") {
  Scene ball = empty_scene();
  ball.bodies.push_back(box({1, 1, 1}, {0.3, 1, 0.2}));
  const BodySample truth = end_of("verner9", "quad", false, ball, 10, 1000);
  for (const std::int64_t steps : {65536, 262144}) {
    INFO(steps << " steps");
    CHECK(attitude_error(end_of("dopri5", "double", true, ball, 10, steps), truth) < 1.5 * 0x1p-52);
    CHECK(attitude_error(end_of("dopri5", "double", false, ball, 10, steps), truth) > 20 * 0x1p-52);
  }
}

TEST_CASE("a compensated quaternion stays of unit length") {
  Wide size = 0;
  for (const Wide part : end_of("rk4", "double", true, free_box(), 10, 20000).q_wxyz) size += part * part;
  CHECK(std::fabs(static_cast<double>(size - 1)) < 1e-15);
}

}  // namespace
}  // namespace atwood::testing
