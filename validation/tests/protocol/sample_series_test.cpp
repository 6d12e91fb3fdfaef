// Samples in a series are those that were put in, also where their lists differ in length.
#include <catch2/catch.hpp>

#include <algorithm>

#include "protocol/sample_series.hpp"

using namespace atwood;

namespace {

// Sample k has k + 1 bodies where `growing`, else 2; contacts at every third.
Sample made(int k, bool growing) {
  Sample sample;
  sample.t_s = k;
  sample.bodies.resize(growing ? static_cast<std::size_t>(k) + 1 : 2);
  for (BodySample& body : sample.bodies) body.p_m = {Wide(k) / 3, 1, 2};
  if (k % 3 == 2) sample.contacts = {{0, 1, {1.0 * k, 2, 3}, {0, 0, 1}, 0, 9.8, {}}};
  return sample;
}

void check(const SampleView& found, const Sample& expected) {
  CHECK(found.t_s == expected.t_s);
  REQUIRE(found.bodies.size() == expected.bodies.size());
  for (std::size_t i = 0; i < found.bodies.size(); ++i) CHECK(found.bodies[i].p_m == expected.bodies[i].p_m);
  CHECK(copy_of(found).contacts == expected.contacts);
  CHECK(found.particles.empty());
}

}  // namespace

TEST_CASE("a series holds its samples, whether their lists are of one length or not") {
  for (const bool growing : {false, true}) {
    std::vector<Sample> samples;
    for (int k = 0; k < 10; ++k) samples.push_back(made(k, growing));
    SampleSeries series = samples;
    REQUIRE(series.size() == 10);
    for (std::size_t k = 0; k < 10; ++k) check(series[k], samples[k]);
    check(series.front(), samples.front());
    check(series.back(), samples.back());
    series.truncate(6);
    REQUIRE(series.size() == 6);
    check(series.back(), samples[5]);
    series.push_back(samples[9]);  // goes on where it was cut
    check(series[6], samples[9]);
    check(series[5], samples[5]);
    CHECK_THROWS_AS(series.at(7), std::out_of_range);
    CHECK_THROWS_AS(checked(series[0].bodies, 2), std::out_of_range);
    series.clear();
    CHECK(series.empty());
    series.push_back(samples[3]);
    check(series[0], samples[3]);
  }
}

TEST_CASE("a series is changed in place, gone through and searched") {
  SampleSeries series;
  series.reserve(5, 2);
  for (int k = 0; k < 5; ++k) series.push_back(made(k, false));
  const SampleSeries before = series;
  series[2].bodies[1].p_m[0] = 7;
  series.back().t_s = 10;
  CHECK(series[2].bodies[1].p_m[0] == 7);
  CHECK(series.at(4).t_s == 10);
  CHECK(before[2].bodies[1].p_m[0] == Wide(2) / 3);
  Wide sum = 0;
  for (const SampleView sample : before) sum += sample.t_s;
  CHECK(sum == 10);
  for (const SampleReference sample : series) sample.t_s *= 2;
  CHECK(series[1].t_s == 2);
  const auto from = std::lower_bound(before.begin(), before.end(), Wide(2.5),
                                     [](const SampleView& sample, Wide t) { return sample.t_s < t; });
  CHECK(from - before.begin() == 3);
  CHECK(from->t_s == 3);
}
