// The two formulations of mechanisms against each other, in quad: accelerations and reactions at random states.
#include <catch2/catch.hpp>

#include "mechanism/maximal.hpp"
#include "mechanism/reduced.hpp"
#include "random_mechanism.hpp"

using namespace atwood;
using mechanism::Maximal;
using mechanism::Reduced;

namespace {

// The scene's start as a sample: bodies that no joint places, and the joints' coordinates and rates.
Sample start_of(const Scene& scene) {
  Sample made;
  for (const Body& body : scene.bodies) {
    BodySample& at = made.bodies.emplace_back();
    for (int k = 0; k < 3; ++k) {
      at.p_m[k] = body.position_m[k];
      at.v_m_per_s[k] = body.velocity_m_per_s[k];
      at.w_rad_per_s[k] = body.angular_velocity_body_rad_per_s[k];
    }
    for (int k = 0; k < 4; ++k) at.q_wxyz[k] = body.orientation_wxyz[k];
  }
  for (const Joint& joint : scene.joints) {
    JointSample& at = made.joints.emplace_back();
    for (int k = 0; k < 4; ++k) at.q[k] = joint.coordinates[k];
    for (int k = 0; k < 3; ++k) at.u[k] = joint.rates[k];
  }
  return made;
}

template <std::size_t N> double apart(const std::array<Wide, N>& a, const std::array<Wide, N>& b) {
  double largest = 0;
  for (std::size_t k = 0; k < N; ++k) largest = std::max(largest, std::fabs(static_cast<double>(a[k] - b[k])));
  return largest;
}

}  // namespace

TEST_CASE("trees: maximal and reduced coordinates agree to the round-off of quad") {
  for (int seed = 1; seed <= 40; ++seed) {
    const Scene scene = random_tree(seed, 1 + seed % 7);
    INFO("seed " << seed);
    REQUIRE(mechanism::unsupported(scene).empty());
    const Sample start = start_of(scene);
    Reduced<Wide> reduced(scene, 1, start);
    const std::vector<Wide> y = reduced.initial(start);
    reduced.choose(0, y.data());
    const Sample one = reduced.sample(0, y.data());
    Maximal<Wide> maximal(scene, 1, one);
    const std::vector<Wide> full = maximal.initial(one);
    const mechanism::Independence rank = maximal.choose(0, full.data());
    CHECK(rank.rank == 0);
    const Sample other = maximal.sample(0, full.data());
    REQUIRE(other.joints.size() == scene.joints.size());
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      INFO("joint " << j << " of kind " << static_cast<int>(scene.joints[j].kind));
      const JointSample &a = one.joints[j], &b = other.joints[j];
      CHECK(apart(a.q, start.joints[j].q) < 1e-15);  // the fourth of universal joints and so on are zero
      CHECK(apart(a.q, b.q) < 1e-31);
      CHECK(apart(a.u, b.u) < 1e-30);
      CHECK(apart(a.u, start.joints[j].u) < 1e-30);
      CHECK(apart(a.applied, b.applied) < 1e-29);
      CHECK(apart(a.force_N, b.force_N) < 1e-28);
      CHECK(apart(a.torque_N_m, b.torque_N_m) < 1e-28);
      CHECK(b.not_unique == 0u);
      const int rates = rate_count(scene.joints[j].kind);
      if (rates == 1)
        CHECK(std::fabs(static_cast<double>(reduced.acceleration(0, y.data(), static_cast<int>(j)) -
                                            maximal.acceleration(0, full.data(), static_cast<int>(j)))) < 1e-28);
    }
  }
}
