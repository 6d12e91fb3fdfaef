// Settings against their declared rules: types, ranges, choices, and the words of a refusal.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "protocol/method.hpp"
#include "protocol/printed_setting.hpp"

using namespace atwood;

namespace {

MethodInfo demo() {
  MethodInfo info{"demo/a", "doc", "source", {}, false, {{"unruled", 1.0}}};
  declare_settings(info, {{"scalar", std::string("double")},
                          {"substeps", std::int64_t(4), {between(0, 1000), "Substeps."}},
                          {"overlap", 0.5, {strictly_between(0, 1), "Overlap."}},
                          {"speed", 1.0, {at_least(0), "Speed.", "m/s"}},
                          {"beta", 1.0, {above(0), "Exponent."}},
                          {"law", std::string("newton"), {one_of({"newton", "poisson", "stronge"}), "Law."}},
                          {"warm", true, {{}, "Warm start."}},
                          printed("solver", std::string("newton")),
                          printed("sleeping", false),
                          printed("damping", 0.0)});
  return info;
}

std::string reason(const Settings& overrides) {
  const Result<Settings> merged = merged_settings(demo(), overrides);
  if (merged) return "";
  return merged.fault().reason;
}

}  // namespace

TEST_CASE("settings: a value of the declared type and range replaces the default, and no other does") {
  const Result<Settings> merged =
      merged_settings(demo(), {{"substeps", std::int64_t(1000)}, {"speed", std::int64_t(0)}});
  REQUIRE(merged);
  CHECK(std::get<std::int64_t>(merged->at("substeps")) == 1000);
  CHECK(std::get<double>(merged->at("speed")) == 0);  // a whole number where a real one is taken
  CHECK(std::get<std::string>(merged->at("law")) == "newton");
  CHECK(merged->size() == 11);
  CHECK(reason({{"unruled", -1e300}}).empty());
  CHECK(reason({{"overlap", std::nextafter(1.0, 0.0)}}).empty());
}

TEST_CASE("settings: a refusal names the setting, what was found and what is expected") {
  CHECK(reason({{"substeps", std::int64_t(-1)}}) ==
        "demo/a: `substeps` is `-1`; expected a whole number from 0 to 1000");
  CHECK(reason({{"substeps", 1e9}}) == "demo/a: `substeps` is `1e+09`; expected a whole number from 0 to 1000");
  CHECK(reason({{"overlap", 0.0}}) == "demo/a: `overlap` is `0`; expected a number above 0 and below 1");
  CHECK(reason({{"overlap", std::int64_t(1)}}) == "demo/a: `overlap` is `1`; expected a number above 0 and below 1");
  CHECK(reason({{"speed", -1.0}}) == "demo/a: `speed` is `-1`; expected a number of at least 0");
  CHECK(reason({{"beta", 0.0}}) == "demo/a: `beta` is `0`; expected a number above 0");
  CHECK(reason({{"law", std::string("newtn")}}) == "demo/a: `law` is `newtn`; expected newton, poisson or stronge");
  CHECK(reason({{"warm", std::int64_t(1)}}) == "demo/a: `warm` is `1`; expected true or false");
  CHECK(reason({{"unruled", std::string("x")}}) == "demo/a: `unruled` is `x`; expected a number");
  CHECK(reason({{"bounce", 1.0}}) ==
        "demo/a has no setting `bounce`; expected one of beta, law, overlap, speed, substeps, unruled, warm");
  CHECK(reason({{"solver", std::string("lu")}}) == "demo/a: `solver` is `lu`; expected newton");
  CHECK(reason({{"sleeping", true}}) == "demo/a: `sleeping` is `true`; expected false");
  CHECK(reason({{"damping", 0.5}}) == "demo/a: `damping` is `0.5`; expected 0");
  CHECK(reason({{"damping", 0.0}, {"sleeping", false}}).empty());
  CHECK(reason({{"scalar", std::string("float")}}) ==
        "demo/a: `scalar` is not set in braces; expected it behind @, as in demo/a@float");
}

TEST_CASE("settings: NaN and infinities lie outside every range that is bounded there") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const char* name : {"overlap", "speed", "beta"}) {
    CHECK_FALSE(reason({{name, std::nan("")}}).empty());
    CHECK_FALSE(reason({{name, -infinity}}).empty());
  }
  CHECK_FALSE(reason({{"overlap", infinity}}).empty());
}
