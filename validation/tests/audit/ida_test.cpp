#include "ida/ida.hpp"

#include "motion.hpp"

using namespace atwood;
using namespace atwood::testing;

TEST_CASE("IDA on y' - f = 0: a tighter tolerance is nearer the truth") {
  const Engine ida = ida_engine();
  for (const Scenario& given : {orbit(), driven()}) {
    const double loose = end_error(ida, "ida/bdf:1e-5", given, 1), tight = end_error(ida, "ida/bdf:1e-10", given, 1);
    CAPTURE(given.id, loose, tight);
    CHECK(tight < loose / 100);
    CHECK(tight < 1e-6);
  }
  CHECK(end_error(ida, "ida/bdf", orbit(), 1) ==
        end_error(ida, "ida/bdf:1e-10", orbit(), 1));  // the default is what it says
  CHECK(end_error(ida, "ida/bdf:1e-8{max_order=2}", orbit(), 1) != end_error(ida, "ida/bdf:1e-8", orbit(), 1));
}

TEST_CASE("Requests that IDA does not cover are refused with a reason") {
  const Engine ida = ida_engine();
  for (const std::string method : {"ida/adams", "ida/bdf@float", "ida/bdf+event", "ida/bdf{max_order=6}"}) {
    const Run made = try_run(ida, method, orbit(), 10);
    CHECK(made.outcome.status == Status::unsupported);
    CHECK_FALSE(made.outcome.reason.empty());
  }
  CHECK(ida.methods.at(0).settings.contains("linear_solver"));
}
