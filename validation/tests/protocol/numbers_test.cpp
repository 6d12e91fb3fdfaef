// Text of numbers is exact both ways, in every precision.
#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "protocol/sample.hpp"

using namespace atwood;

namespace {

// Any finite double, all magnitudes alike.
double any_double(std::mt19937_64& random) {
  for (;;) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) return value;
  }
}

}  // namespace

TEST_CASE("the shortest text of a double reads back as that double") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const double value = any_double(random);
    CHECK(parse_wide(format_double(value)) == static_cast<Wide>(value));
    CHECK(parse_wide(format_number(value, 17)) == static_cast<Wide>(value));
  }
  for (const double edge : {0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, -0.1, 1.0 / 3.0}) {
    CHECK(parse_wide(format_double(edge)) == static_cast<Wide>(edge));
  }
  CHECK(format_double(0.1) == "0.1");
  CHECK(format_double(1e22) == "1e+22");
}

TEST_CASE("21 digits carry a long double, 36 a quad, and a double in either") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const double coarse = unit(random) * std::exp2(static_cast<double>(i % 400 - 200));
    const long double longer =
        static_cast<long double>(coarse) * (1 + static_cast<long double>(unit(random)) * 0x1p-53L);
    const Wide wide = static_cast<Wide>(longer) * (1 + static_cast<Wide>(unit(random)) * static_cast<Wide>(0x1p-64L));
    CHECK(parse_wide(format_number(longer, 21)) == static_cast<Wide>(longer));
    CHECK(parse_wide(format_number(wide, 36)) == wide);
    CHECK(parse_wide(format_number(coarse, 21)) == static_cast<Wide>(coarse));
    CHECK(parse_wide(format_number(coarse, 36)) == static_cast<Wide>(coarse));
  }
}

TEST_CASE("a wide value whose text is short keeps its precision") {
  const Wide tenth = static_cast<Wide>(1) / 10;  // in quad, not the double 0.1
  CHECK(tenth != static_cast<Wide>(0.1));
  CHECK(parse_wide(format_number(tenth, 36)) == tenth);
  const long double long_tenth = 0.1L;
  CHECK(parse_wide(format_number(long_tenth, 21)) == static_cast<Wide>(long_tenth));
  CHECK(parse_wide("0.1") == static_cast<Wide>(0.1));  // a decimal is rounded to double first
}

TEST_CASE("values that are not finite have names") {
  CHECK(format_double(std::nan("")) == "nan");
  CHECK(format_double(-std::numeric_limits<double>::infinity()) == "-inf");
  CHECK(format_number(std::numeric_limits<double>::infinity(), 36) == "inf");
  CHECK(static_cast<double>(parse_wide("-inf")) == -std::numeric_limits<double>::infinity());
  CHECK(std::isnan(static_cast<double>(parse_wide("nan"))));
  CHECK(parse_wide("1e-4000") > 0);  // beyond double's range
  CHECK(parse_wide(format_number(parse_wide("1e4000"), 36)) == parse_wide("1e4000"));
}

TEST_CASE("text that is not a number is refused") {
  for (const char* text : {"", " 1", "1 ", "one", "1,5", "0x10", "1e", "--1", "1.2.3", "nan(7)"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_wide(text), std::invalid_argument);
  }
}

TEST_CASE("statuses and events go by their published names") {
  for (const char* name : {"ok", "unsupported", "diverged", "not finite", "timeout", "crashed", "not built"}) {
    CHECK(to_string(status_from_string(name)) == name);
  }
  for (const char* name : {"impact", "rest", "slip", "stick", "roll", "separate"}) {
    CHECK(to_string(event_kind_from_string(name)) == name);
  }
  CHECK(to_string(Status::not_finite) == "not finite");
  CHECK_THROWS_AS(status_from_string("not_finite"), std::invalid_argument);
  CHECK_THROWS_AS(event_kind_from_string("bounce"), std::invalid_argument);
}
