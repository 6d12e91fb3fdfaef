// Scenes of the catalogue that both the walk over impacts in closed form and the extended truth solve: two derivations,
// two codes, one motion.
#include <quadmath.h>

#include <catch2/catch.hpp>

#include "closed_form/closed_form.hpp"
#include "extended/extended.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;

TEST_CASE("slopes, cradles, a thin wall: closed form and located impacts agree within their bars") {
  for (const char* id :
       {"slopes", "cradle-touching-3", "cradle-unequal-apart", "bullet-through-paper", "oblique-rough-dead"}) {
    const Scenario given = testing::catalogued(id);
    const Truth exact = closed_form_truth(given, given.samples), located = extended_truth(given, given.samples);
    INFO(id << ": " << exact.outcome.reason << located.outcome.reason);
    REQUIRE(exact.outcome.status == Status::ok);
    REQUIRE(located.outcome.status == Status::ok);
    REQUIRE(exact.events.size() == located.events.size());
    const auto close = [](const auto& a, const auto& b, const auto& bar_a, const auto& bar_b) {
      for (std::size_t c = 0; c < a.size(); ++c) {
        CHECK(static_cast<double>(fabsq(a[c] - b[c])) <= static_cast<double>(bar_a[c] + bar_b[c]));
        CHECK(static_cast<double>(bar_a[c] + bar_b[c]) < 1e-22);
      }
    };
    for (std::size_t k = 1; k < exact.values.size(); ++k)
      for (std::size_t i = 0; i < given.scene.bodies.size(); ++i) {
        if (given.scene.bodies[i].fixed) continue;
        const BodySample &a = exact.values[k].bodies[i], &b = located.values[k].bodies[i];
        const BodySample &p = exact.bars[k].bodies[i], &q = located.bars[k].bodies[i];
        close(a.p_m, b.p_m, p.p_m, q.p_m);
        close(a.v_m_per_s, b.v_m_per_s, p.v_m_per_s, q.v_m_per_s);
        close(a.w_rad_per_s, b.w_rad_per_s, p.w_rad_per_s, q.w_rad_per_s);
        close(a.q_wxyz, b.q_wxyz, p.q_wxyz, q.q_wxyz);
      }
  }
}
