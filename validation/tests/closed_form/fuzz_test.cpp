// Random scenes, half of them beside the borders of the formulas, against Taylor series of the equations of motion in
// 60 digits, which share nothing with the closed forms. ATWOOD_FUZZ_COUNT asks for more scenes of each kind,
// ATWOOD_FUZZ_SEED for others.
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "scenes.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

using Long = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
using Series = std::vector<Long>;

constexpr int order = 36;

Long widened(Wide x) {
  Long sum = 0;
  for (int k = 0; k < 4; ++k) {
    const double part = static_cast<double>(x);
    sum += part;
    x -= part;
  }
  return sum;
}

Long product(const Series& a, const Series& b, int n) {  // coefficient n
  Long sum = 0;
  for (int j = 0; j <= n; ++j) sum += a[j] * b[n - j];
  return sum;
}

// I w' = (I w) x w, q' = q w / 2, in steps over which |w| h = `angle`.
std::vector<Long> turned(const Body& body, double t_end_s, double angle) {
  std::vector<Long> y;  // w, q
  for (const double w : body.angular_velocity_body_rad_per_s) y.push_back(w);
  Long length = 0;
  for (const double q : body.orientation_wxyz) length += Long(q) * q;
  for (const double q : body.orientation_wxyz) y.push_back(Long(q) / sqrt(length));
  const Long I[3] = {body.inertia_kg_m2[0], body.inertia_kg_m2[4], body.inertia_kg_m2[8]};
  double rate = 0;
  for (int k = 0; k < 3; ++k) rate += std::fabs(body.angular_velocity_body_rad_per_s[k]);
  const int steps = static_cast<int>(2 * rate * t_end_s / angle) + 1;
  const Long h = Long(t_end_s) / steps;
  std::vector<Series> c(7, Series(order + 1));
  for (int step = 0; step < steps; ++step) {
    for (int i = 0; i < 7; ++i) c[i][0] = y[i];
    for (int n = 0; n < order; ++n) {
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        c[i][n + 1] = (I[j] - I[k]) / I[i] * product(c[j], c[k], n) / (n + 1);
      }
      const auto q = [&](int a, int b) { return product(c[3 + a], c[b - 1], n); };
      const Long half = Long(1) / (2 * (n + 1));
      c[3][n + 1] = half * (-q(1, 1) - q(2, 2) - q(3, 3));
      c[4][n + 1] = half * (q(0, 1) + q(2, 3) - q(3, 2));
      c[5][n + 1] = half * (q(0, 2) + q(3, 1) - q(1, 3));
      c[6][n + 1] = half * (q(0, 3) + q(1, 2) - q(2, 1));
    }
    for (int i = 0; i < 7; ++i) {
      Long sum = c[i][order];
      for (int n = order - 1; n >= 0; --n) sum = sum * h + c[i][n];
      y[i] = sum;
    }
  }
  return y;
}

// worst: error over bar
struct Answer {
  bool answered = false;
  double worst = 0;
};

// The error of the checker is the difference to another step size; it is included.
Answer against_taylor(const Scenario& given, double angle = 0.3) {
  const Truth truth = closed_form_truth(given, 2);
  UNSCOPED_INFO(truth.outcome.reason);
  if (truth.outcome.status != Status::ok) return {};
  const std::vector<Long> y = turned(given.scene.bodies[0], given.t_end_s, angle);
  const BodySample &end = truth.values.back().bodies[0], &bar = truth.bars.back().bodies[0];
  Answer made{true, 0};
  const auto hold = [&](Wide value, const Long& exact, Wide half_width) {
    made.worst = std::max(made.worst, static_cast<double>(abs(widened(value) - exact) / widened(half_width)));
  };
  for (int k = 0; k < 3; ++k) hold(end.w_rad_per_s[k], y[k], bar.w_rad_per_s[k]);
  for (int k = 0; k < 4; ++k) hold(end.q_wxyz[k], y[3 + k], bar.q_wxyz[k]);
  return made;
}

Scenario top(Real3 I, Real3 w, double t_end_s) {
  Scenario given = scenario("free-rigid-body", t_end_s);
  given.scene.bodies = {solid("top", 1, I, w)};
  return given;
}

int number_from(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}

}  // namespace

TEST_CASE("Tops on the separatrix, in each of its quarters, and beside the middle axis") {
  for (const double s1 : {1.0, -1.0})
    for (const double s2 : {1.0, -1.0})
      for (const double s3 : {1.0, -1.0}) {
        const Answer exact = against_taylor(top({3, 5, 6}, {s1, 0.5 * s2, s3}, 6));
        INFO(s1 << " " << s2 << " " << s3);
        CHECK(exact.answered);
        CHECK(exact.worst < 1);
      }
  for (const Real3 w : {Real3{0, 1, 1e-12}, {1e-12, 1, 0}, {-1e-12, -1, 0}, {1e-9, 1, -1e-9}, {0, 1.5, -1e-15}}) {
    for (const double t : {3.0, 12.0}) {
      const Answer beside = against_taylor(top({0.5, 0.6, 0.7}, w, t));
      INFO(w[0] << " " << w[1] << " " << w[2] << " at " << t);
      CHECK(beside.worst < 1);
    }
  }
}

TEST_CASE("Random tops, half of them beside the separatrix or the middle axis, stay within their bars") {
  const int count = number_from("ATWOOD_FUZZ_COUNT", 16), seed = number_from("ATWOOD_FUZZ_SEED", 1784);
  int answered = 0;
  for (int k = 0; k < count; ++k) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) * 1000003u + static_cast<std::uint64_t>(k));
    const auto uniform = [&](double from, double to) {
      return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53;
    };
    Real3 I{uniform(0.5, 1), uniform(0.5, 1), uniform(0.5, 1)};
    if (k % 8 == 7) I[1] = I[0] * (1 + std::pow(10, uniform(-16, -1)));  // nearly symmetric
    Real3 w{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    Real3 sorted = I;
    std::sort(sorted.begin(), sorted.end());
    if (k % 4 == 1) {  // I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2 to a small part
      I = sorted;
      w[2] = w[0] * std::sqrt(I[0] * (I[1] - I[0]) / (I[2] * (I[2] - I[1]))) * (1 + std::pow(10, uniform(-17, -1)));
    }
    if (k % 4 == 3) {
      I = sorted;
      w[0] = (w[0] < 0 ? -1 : 1) * std::pow(10, uniform(-20, -1));
      w[2] = (w[2] < 0 ? -1 : 1) * std::pow(10, uniform(-20, -1));
    }
    const double t_end_s = uniform(0.5, 12);
    const Answer made = against_taylor(top(I, w, t_end_s));
    INFO("seed " << seed << ", scene " << k << ": I " << I[0] << " " << I[1] << " " << I[2] << ", w " << w[0] << " "
                 << w[1] << " " << w[2] << ", t " << t_end_s);
    if (made.answered) ++answered;
    CHECK(made.worst < 1);
  }
  CHECK(answered >= 3 * count / 4);
}
