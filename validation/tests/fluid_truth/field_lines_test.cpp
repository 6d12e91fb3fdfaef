// The lines that ask for a field and answer it: what is written is what is read, also in parts.
#include <catch2/catch.hpp>
#include <limits>

#include "protocol/fluid_field.hpp"

using namespace atwood;

TEST_CASE("A question for a field is read as it was written") {
  wire::FieldRequest asked;
  asked.cell = 7;
  asked.response = "sph{kernel=wendland-c4,viscosity=central}";
  asked.scenario = R"({"id":"x"})";
  asked.t_s = {0, Wide(1) / 3};
  asked.positions = {{{0.5, 1, 0}, {Wide(2) / 3, -1, 0}}, {}};
  const std::string line = wire::to_line(asked);
  std::int64_t cell = -1;
  CHECK(wire::read_request(line, cell).kind == wire::Request::Kind::field);
  CHECK(cell == 7);
  const wire::FieldRequest read = wire::read_field_request(line);
  CHECK(read.cell == 7);
  CHECK(read.response == asked.response);
  CHECK(read.scenario == asked.scenario);
  CHECK(read.t_s == asked.t_s);
  CHECK(read.positions == asked.positions);
  CHECK_THROWS_WITH(wire::read_field_request(R"({"cell":1,"scenario":{},"t_s":[0,1],"positions":[[]]})"),
                    Catch::Contains("1 lists and 2 times"));
  CHECK_THROWS_AS(wire::read_field_request(R"({"cell":1,"scenario":{},"t_s":[0],"positions":[[[1,2]]]})"),
                  wire::Garbage);
}

TEST_CASE("A field is read as it was written, in one line or in many") {
  FieldSample field;
  field.t_s = Wide(1) / 7;
  const double infinite = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 50; ++k) {
    field.values.push_back({{}, {Wide(k) / 3, Wide(-k), 0}, 1000, Wide(k) * k, 300});
    field.bars.push_back({{}, {Wide(1e-30), infinite, 0}, 0, 1e-3, 0});
  }
  field.probes = {std::nullopt, ProbeValue{Wide(2) / 3, 1e-20}};
  for (const std::size_t longest : {std::size_t{1} << 20, std::size_t{600}}) {
    std::vector<std::string> lines;
    wire::field_lines(
        3, field, [&](const std::string& line) { lines.push_back(line); }, longest);
    CHECK((lines.size() > 1) == (longest == 600));
    FieldSample read;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const wire::FieldAnswer part = wire::read_field_answer(lines[k]);
      CHECK(part.cell == 3);
      CHECK(part.from == read.values.size());
      CHECK(part.more == (k + 1 < lines.size()));
      CHECK(part.sample.t_s == field.t_s);
      read.values.insert(read.values.end(), part.sample.values.begin(), part.sample.values.end());
      read.bars.insert(read.bars.end(), part.sample.bars.begin(), part.sample.bars.end());
      read.probes = part.sample.probes;
    }
    REQUIRE(read.values.size() == 50);
    for (int k = 0; k < 50; ++k) {
      CHECK(read.values[k].v_m_per_s == field.values[k].v_m_per_s);
      CHECK(read.values[k].pressure_Pa == field.values[k].pressure_Pa);
      CHECK(read.bars[k].v_m_per_s == field.bars[k].v_m_per_s);
    }
    REQUIRE(read.probes.size() == 2);
    CHECK_FALSE(read.probes[0]);
    CHECK(read.probes[1]->value == field.probes[1]->value);
  }
  FluidField ended;
  ended.source = "closed form: x";
  ended.known = {true, false, false, true};
  const wire::FieldAnswer done = wire::read_field_answer(wire::field_done_line(3, ended));
  CHECK(done.done);
  CHECK(done.ended.source == "closed form: x");
  CHECK(done.ended.known.velocity);
  CHECK_FALSE(done.ended.known.pressure);
  CHECK(done.ended.known.temperature);
  CHECK_THROWS_WITH(wire::read_field_answer(R"({"cell":3,"field_t_s":0,"values":[[1,2,3,4,5,6]],"bars":[]})"),
                    Catch::Contains("differ in size"));
}
