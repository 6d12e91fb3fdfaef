#include <catch2/catch.hpp>

#include "protocol/method.hpp"

using namespace atwood;

TEST_CASE("a method id is read part by part") {
  const MethodId id = parse_method_id("atwood/dopri5:1e-8,1e-11+event@long-double{a=1,b=0.5,c=true,d=word}");
  CHECK(id.engine == "atwood");
  CHECK(id.scheme == "dopri5");
  CHECK(id.rtol.value() == 1e-8);
  CHECK(id.atol.value() == 1e-11);
  CHECK(id.response == "event");
  CHECK(id.scalar == "long-double");
  CHECK(std::get<std::int64_t>(id.overrides.at("a")) == 1);
  CHECK(std::get<double>(id.overrides.at("b")) == 0.5);
  CHECK(std::get<bool>(id.overrides.at("c")));
  CHECK(std::get<std::string>(id.overrides.at("d")) == "word");

  const MethodId plain = parse_method_id("arkode/erkstep/VERNER_8_5_6");
  CHECK(plain.scheme == "erkstep/VERNER_8_5_6");
  CHECK_FALSE(plain.rtol.has_value());
  CHECK(parse_method_id("truth").engine == "truth");
  CHECK_FALSE(parse_method_id("cvode/adams:1e-10").atol.has_value());
}

TEST_CASE("the canonical text of a method id reads back as the same id") {
  for (const char* text : {"atwood/rk4", "cvode/adams:1e-10", "atwood/rk4+event", "atwood/rk4@float", "truth",
                           "atwood/dopri5:1e-08,1e-11+impulse@quad", "ode/default{cfm=1e-05,erp=0.1}",
                           "ode/default{n=3,x=1.0,y=\"3\",z=\"a,b}\\\"\",flag=false}", "arkode/erkstep/VERNER_8_5_6"}) {
    CAPTURE(text);
    const MethodId id = parse_method_id(text);
    const MethodId again = parse_method_id(to_string(id));
    CHECK(to_string(again) == to_string(id));
    CHECK(again.engine == id.engine);
    CHECK(again.scheme == id.scheme);
    CHECK(again.rtol == id.rtol);
    CHECK(again.atol == id.atol);
    CHECK(again.response == id.response);
    CHECK(again.scalar == id.scalar);
    CHECK(again.overrides == id.overrides);
  }
  CHECK(to_string(parse_method_id("cvode/adams:1E-10")) == "cvode/adams:1e-10");
  CHECK(to_string(parse_method_id("a/b{c=x{,d=1}")) == "a/b{c=x{,d=1}");
  CHECK(std::holds_alternative<double>(parse_method_id("ode/default{x=1.0}").overrides.at("x")));
  CHECK(std::holds_alternative<std::string>(parse_method_id("ode/default{x=\"1\"}").overrides.at("x")));
}

TEST_CASE("an ambiguous or malformed method id is refused with what was expected") {
  for (const char* text : {"", "rk4", "/rk4", "atwood/", "atwood/rk4:", "atwood/rk4:zero", "atwood/rk4:-1e-3",
                           "atwood/rk4:0", "atwood/rk4:nan", "atwood/rk4+bounce", "atwood/rk4@half",
                           "atwood/rk4@float+event", "ode/default{erp}", "ode/default{erp=0.1", "ode/default{erp=0.1}x",
                           "ode/default{a=1,a=2}", "ode/default{a=\"1}", "atwood/rk4:1e-3,", "atwood/rk4+"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(parse_method_id(text), Catch::Contains("expected"));
  }
}
