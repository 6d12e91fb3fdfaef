// Particles of fluids on the wire: whole, in parts, with bars; and what is not the protocol.
#include <catch2/catch.hpp>

#include <limits>

#include "protocol/wire.hpp"

using namespace atwood;
using Catch::Contains;

namespace {

Sample particles(std::size_t count, std::size_t bodies) {
  Sample sample;
  sample.t_s = 0.1;
  sample.bodies.resize(bodies);
  for (std::size_t i = 0; i < count; ++i) {
    ParticleSample& p = sample.particles.emplace_back();
    const Wide x = static_cast<Wide>(i) / 3;
    p.p_m = {x, 2 * x, 0};
    p.v_m_per_s = {-x, 0.5, std::numeric_limits<double>::infinity()};
    p.density_kg_per_m3 = 1000 + x, p.pressure_Pa = -x, p.temperature_K = 293.15;
  }
  return sample;
}

void check_equal(const std::vector<ParticleSample>& a, const std::vector<ParticleSample>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].p_m == b[i].p_m);
    CHECK(a[i].v_m_per_s == b[i].v_m_per_s);
    CHECK(a[i].density_kg_per_m3 == b[i].density_kg_per_m3);
    CHECK(a[i].pressure_Pa == b[i].pressure_Pa);
    CHECK(a[i].temperature_K == b[i].temperature_K);
  }
}

}  // namespace

TEST_CASE("particles cross with their sample; a sample without any says nothing of them") {
  const Sample sample = particles(5, 1);
  const wire::Answer answer = wire::read_answer(wire::sample_line(7, sample, {}));
  check_equal(answer.sample.particles, sample.particles);
  CHECK(wire::sample_line(7, particles(0, 1), {}).find("particle") == std::string::npos);
  const wire::Answer truth = wire::read_answer(wire::truth_line(7, sample, particles(5, 1)));
  check_equal(truth.bar.particles, sample.particles);
}

TEST_CASE("many particles cross in parts, with their bars, also without bodies and with contacts after them") {
  for (const std::size_t bodies : {std::size_t{0}, std::size_t{3}})
    for (const bool with_bar : {false, true}) {
      Sample sample = particles(100, bodies);
      sample.contacts.resize(2);
      std::vector<ParticleSample> found, bars;
      std::size_t found_bodies = 0, contacts = 0;
      int lines = 0;
      bool more = true;
      const SampleView bar = sample;
      wire::sample_lines(
          7, sample, with_bar ? &bar : nullptr, {},
          [&](const std::string& line) {
            const wire::Answer part = wire::read_answer(line);
            REQUIRE(more);
            CHECK(part.from == found_bodies);
            CHECK(part.from_particle == found.size());
            found_bodies += part.sample.bodies.size();
            contacts += part.sample.contacts.size();
            found.insert(found.end(), part.sample.particles.begin(), part.sample.particles.end());
            bars.insert(bars.end(), part.bar.particles.begin(), part.bar.particles.end());
            CHECK(line.size() < 1400);
            more = part.more;
            ++lines;
          },
          600);
      CHECK_FALSE(more);
      CHECK(lines > 10);
      CHECK(found_bodies == bodies);
      CHECK(contacts == 2);
      check_equal(found, sample.particles);
      if (with_bar) check_equal(bars, sample.particles);
      else CHECK(bars.empty());
    }
}

TEST_CASE("rows of particles that are not the protocol are garbage") {
  const auto read = [](const std::string& members) {
    return wire::read_answer("{\"cell\":7,\"t_s\":0,\"bodies\":[]," + members + "}", {.particles = 2});
  };
  const std::string row = "[0,0,0,0,0,0,1,0,0]";
  CHECK_NOTHROW(read("\"particles\":[" + row + "," + row + "]"));
  CHECK_THROWS_WITH(read("\"particles\":[[0,0,0]]"), Contains("\"particle\" is not an array of 9"));
  CHECK_THROWS_WITH(read("\"particles\":[" + row + "," + row + "," + row + "]"), Contains("more than 2 particles"));
  CHECK_THROWS_WITH(read("\"bars\":[],\"particles\":[" + row + "]"), Contains("differ in size"));
  CHECK_THROWS_WITH(read("\"particles\":[" + row + "],\"particle_bars\":[" + row + "]"), Contains("differ in size"));
}

TEST_CASE("hello tells of fluids") {
  Engine engine;
  engine.name = "e", engine.scalar = "double";
  CHECK_FALSE(wire::read_hello(wire::hello_line(engine)).fluids);
  engine.fluids = true;
  CHECK(wire::read_hello(wire::hello_line(engine)).fluids);
}
