// Direct sums of mutual gravity: the bits of the plain loop over pairs, whatever the width, the threads and the
// remainder; the right values, by sums in quad.
#include <catch2/catch.hpp>

#include "forces/gravity_many.hpp"
#include "many_bodies.hpp"

namespace atwood::testing {
namespace {

// The oracle: Newton's third law pair by pair, as two lines of algebra and no lanes.
template <class S> std::vector<Vec3<S>> over_pairs(const Scene& scene) {
  const auto& gravity = std::get<MutualGravity>(scene.forces[0]);
  const S softening2 = S(gravity.softening_m) * S(gravity.softening_m);
  std::vector<Vec3<S>> a(scene.bodies.size(), narrow3<S>(scene.gravity_m_per_s2));
  const auto Gm = [&](std::size_t i) { return S(gravity.constant_m3_per_kg_s2) * S(scene.bodies[i].mass_kg); };
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = i + 1; j < a.size(); ++j) {
      const Vec3<S> r = narrow3<S>(scene.bodies[j].position_m) - narrow3<S>(scene.bodies[i].position_m);
      const S r2 = dot(r, r) + softening2;
      const S inverse_cube = S(1) / (r2 * real::sqrt(r2));
      a[i] += (Gm(j) * inverse_cube) * r;
      a[j] -= (Gm(i) * inverse_cube) * r;
    }
  return a;
}

// The scene as a run in S starts from it.
template <class S> Scene narrowed(Scene scene) {
  for (Body& body : scene.bodies) {
    body.mass_kg = static_cast<double>(S(body.mass_kg));
    for (double& x : body.position_m) x = static_cast<double>(S(x));
  }
  auto& softening_m = std::get<MutualGravity>(scene.forces[0]).softening_m;
  softening_m = static_cast<double>(S(softening_m));
  return scene;
}

// The scale of each body's round-off: the sum of the magnitudes of its terms.
std::vector<double> magnitudes(const Scene& scene) {
  const auto& gravity = std::get<MutualGravity>(scene.forces[0]);
  std::vector<double> sums(scene.bodies.size());
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (std::size_t j = 0; j < sums.size(); ++j) {
      if (i == j) continue;
      const Vec3<double> r = narrow3<double>(scene.bodies[j].position_m) - narrow3<double>(scene.bodies[i].position_m);
      const double r2 = dot(r, r) + gravity.softening_m * gravity.softening_m;
      sums[i] += scene.bodies[j].mass_kg * std::sqrt(dot(r, r)) / (r2 * std::sqrt(r2));
    }
  return sums;
}

// Largest error of the model's accelerations against quad, in units of (N + 12) eps/2 times the magnitudes' sum: each
// term is rounded nine times or so and then added N times (Higham, Accuracy and Stability, eq. 4.4).
template <class S> double worst_over_bound(const Scene& wide) {
  const Scene scene = narrowed<S>(wide);
  const auto model = model_accelerations<S>(scene);
  const auto truth = over_pairs<Quad>(scene);
  const auto scale = magnitudes(scene);
  double worst = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const Vec3<Quad> error{Quad(model[i].x) - truth[i].x, Quad(model[i].y) - truth[i].y, Quad(model[i].z) - truth[i].z};
    const double bound =
        (static_cast<double>(model.size()) + 12) * static_cast<double>(real::epsilon<S>()) / 2 * scale[i];
    worst = std::max(worst, static_cast<double>(norm(error)) / bound);
  }
  return worst;
}

TEST_CASE("lanes give the bits of the loop over pairs, at every remainder") {
  for (int count = kManyBodies; count <= 3 * kGravityBlock + 3; ++count) {
    const Scene scene = random_cloud(count, static_cast<std::uint64_t>(count));
    INFO(count << " bodies");
    CHECK(same_bits(model_accelerations<double>(scene), over_pairs<double>(scene)));
    CHECK(same_bits(model_accelerations<float>(scene), over_pairs<float>(scene)));
  }
}

TEST_CASE("the sum starts from uniform gravity, and fixed bodies attract without moving") {
  Scene scene = random_cloud(37, 5);
  scene.gravity_m_per_s2 = {0.3, -0.1, -9.8};
  CHECK(same_bits(model_accelerations<double>(scene), over_pairs<double>(scene)));
  scene.bodies[3].fixed = scene.bodies[20].fixed = true;
  auto expected = over_pairs<double>(scene);
  expected[3] = expected[20] = {};
  CHECK(same_bits(model_accelerations<double>(scene), expected));
}

template <class S> std::vector<S> at_one_width(VectorWidth width, int count) {
  const int padded = whole_blocks(count) * kGravityBlock;
  std::vector<S> x(padded), y(padded), z(padded), Gm(count), sums(3 * padded);
  SplitMix64 random{77};
  for (int i = 0; i < count; ++i) {
    x[i] = S(random.next_unit());
    y[i] = S(random.next_unit());
    z[i] = S(random.next_unit());
    Gm[i] = S(random.next_unit());
  }
  const Accelerations<S> at{sums.data(), sums.data() + padded, sums.data() + 2 * padded};
  add_gravity<S>(width, {x.data(), y.data(), z.data(), Gm.data()}, 3, count - 5, S(1e-4), 0, whole_blocks(count), at);
  return sums;
}

TEST_CASE("the same bits at every vector width") {
  for (const VectorWidth width : widths_here()) {
    CHECK(at_one_width<double>(width, 1003) == at_one_width<double>(VectorWidth::narrow, 1003));
    CHECK(at_one_width<float>(width, 1003) == at_one_width<float>(VectorWidth::narrow, 1003));
  }
}

TEST_CASE("the same bits with 1, 2, 3 and 7 threads") {
  const Scene scene = clustered_cloud(523, 9, 1e-3);
  const auto alone = model_accelerations<double>(scene);
  for (const int threads : {2, 3, 7}) {
    ModelOptions options;
    options.threads = threads;
    INFO(threads << " threads");
    CHECK(same_bits(model_accelerations<double>(scene, options), alone));
  }
}

TEST_CASE("direct sums against quad") {
  for (const std::uint64_t seed : {1, 2, 3})
    for (const Scene& scene : {random_cloud(300, seed), random_cloud(100, seed, 0.01), clustered_cloud(200, seed),
                               clustered_cloud(200, seed, 1e-4), coincident_cloud(128, seed, 0.05)}) {
      CHECK(worst_over_bound<double>(scene) < 1);
      const bool knots_collapse =
          std::get<MutualGravity>(scene.forces[0]).softening_m == 0 && scene.bodies.size() == 200;
      if (!knots_collapse) CHECK(worst_over_bound<float>(scene) < 1);  // in float the tight knots are one point
    }
}

TEST_CASE("coincident bodies without softening give a result that is not finite") {
  const auto a = model_accelerations<double>(coincident_cloud(64, 4, 0));
  CHECK(!real::is_finite(a[0].x));
}

// Each body's sum is rounded on its own, so momentum is kept to round-off, not to the bit.
TEST_CASE("mutual gravity conserves momentum") {
  const Scene scene = random_cloud(150, 8, 1e-2);
  const auto a = model_accelerations<double>(scene);
  const auto scale = magnitudes(scene);
  Vec3<Quad> total{};
  double allowed = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double m = scene.bodies[i].mass_kg;
    total += Quad(m) * Vec3<Quad>{Quad(a[i].x), Quad(a[i].y), Quad(a[i].z)};
    allowed += m * scale[i] * (static_cast<double>(a.size()) + 12) * 0x1p-53;
  }
  CHECK(static_cast<double>(norm(total)) < allowed);
  CHECK(allowed < 1e-6);
}

TEST_CASE("settings reach the model: threads, and words that mean nothing are refused") {
  const Scene scene = random_cloud(40, 3, 1e-2);
  const auto end_of = [&](const std::string& method) {
    Sample last;
    Observer observer;
    observer.sample = [&](const Sample& sample) { last = sample; };
    const Outcome outcome = atwood_engine().run(parse_method_id(method), scene, {0.1, 10, 1}, observer, 0);
    return outcome.status == Status::ok ? static_cast<double>(last.bodies[7].p_m[0]) : std::nan("");
  };
  CHECK(end_of("atwood/leapfrog") == end_of("atwood/leapfrog{threads=3}"));
  CHECK(end_of("atwood/leapfrog") == end_of("atwood/leapfrog{gravity=direct}"));
  for (const char* wrong :
       {"atwood/leapfrog{threads=0}", "atwood/leapfrog{threads=1000}", "atwood/leapfrog{gravity=other}",
        "atwood/leapfrog{opening=1.0}", "atwood/leapfrog{opening=0}"}) {
    const Outcome outcome = atwood_engine().run(parse_method_id(wrong), scene, {0.1, 10, 1}, {}, 0);
    INFO(wrong << ": " << outcome.reason);
    CHECK(outcome.status == Status::unsupported);
  }
}

}  // namespace
}  // namespace atwood::testing
