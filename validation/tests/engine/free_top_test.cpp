// The free top by each way: the exact one against published values and collocation, what all of them keep.
#include "rigid/free_top.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "math/so3.hpp"
#include "scenes.hpp"
#include "validation/tests/extended/reference_values.hpp"

namespace atwood::testing {
namespace {

template <class S> struct Top {
  Vec3<S> L;
  Quat<S> q;
};

template <class S> Top<S> turned(const Vec3<S>& g, S h_s, const Top<S>& start) {
  FreeTurn<S> turn;
  exact_turn(g, h_s, start.L, turn);
  const Quat<S> dq = start.q * turn.minus_one;
  return {start.L + turn.dw_B,
          normalised(Quat<S>{start.q.w + dq.w, start.q.x + dq.x, start.q.y + dq.y, start.q.z + dq.z})};
}

template <class S, class T> Vec3<T> cast(const Vec3<S>& v) { return {T(v.x), T(v.y), T(v.z)}; }

template <class S> double apart(const Top<S>& a, const Top<Quad>& b) {
  const Quat<Quad> q{Quad(a.q.w), Quad(a.q.x), Quad(a.q.y), Quad(a.q.z)};
  return static_cast<double>(norm(cast<S, Quad>(a.L) - b.L) / norm(b.L) + norm(so3_log(conjugate(b.q) * q)));
}

struct Case {
  const char* name;
  Real3 moments, w;
};
// Every order of the moments, each axis circled from each side, symmetric tops about each axis, spheres, steady spins,
// nearly on the separatrix and on it.
std::vector<Case> cases() {
  std::vector<Case> all{{"sphere", {2, 2, 2}, {0.3, -1, 0.4}},
                        {"rest", {0.6, 0.8, 1}, {0, 0, 0}},
                        {"first axis", {0.6, 0.8, 1}, {3, 0, 0}},
                        {"middle axis", {0.6, 0.8, 1}, {0, -3, 0}},
                        {"last axis", {0.6, 0.8, 1}, {0, 0, 3}},
                        {"nearly the middle axis", {0.6, 0.8, 1}, {1e-3, 1, 1e-3}},
                        {"nearly the first", {0.6, 0.8, 1}, {3, 1e-9, 1e-12}},
                        {"flat", {1, 1, 2}, {1, 2, 1e-6}},
                        {"long", {1, 0.1, 1}, {1, 1e-7, 2}},
                        {"symmetric, no spin", {1, 1, 0.1}, {1, 2, 0}},
                        {"symmetric, across", {0.3, 1, 1}, {0, 2, 1}},
                        {"nearly symmetric", {1, 1 + 1e-9, 0.4}, {1, 2, 3}},
                        {"nearly a sphere", {1, 1 + 1e-7, 1 - 1e-7}, {1, 2, 3}}};
  const double moments[3] = {0.6, 0.8, 1};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (const double sign : {1.0, -1.0})
        if (i != j)
          for (const Real3& w : {Real3{2, 0.5, sign * 0.7}, Real3{sign * 0.3, -0.6, 2}, Real3{-0.7, sign, -0.6}})
            all.push_back({"any", {moments[i], moments[j], moments[3 - i - j]}, w});
  for (const double tilt : {1.0, 1 + 1e-12, 1 - 1e-12})  // L^2 = 2 E I_2: w3 = w1 sqrt(I1 (I2 - I1) / (I3 (I3 - I2)))
    all.push_back({"separatrix", {0.5, 0.75, 1.5}, {1, 0.4, tilt / 3}});
  return all;
}

Scene free_scene(const Case& c) {
  Scene scene = empty_scene();
  scene.bodies.push_back(box(c.moments, c.w));
  return scene;
}

TEST_CASE("one exact step of any case is what many steps of collocation give, in quad") {
  for (const Case& c : cases()) {
    INFO(c.name << ": moments " << c.moments[0] << " " << c.moments[1] << " " << c.moments[2] << ", rate " << c.w[0]
                << " " << c.w[1] << " " << c.w[2]);
    const double t_end_s = 2.7;
    const BodySample exact = run("jacobi2", free_scene(c), {t_end_s, 1, 1}, "quad").samples.at(1).bodies[0];
    const BodySample truth = run("gauss8", free_scene(c), {t_end_s, 240, 1}, "quad").samples.at(1).bodies[0];
    CHECK(attitude_distance(exact.q_wxyz, truth.q_wxyz) < 2e-14);
    CHECK(distance(exact.w_rad_per_s, truth.w_rad_per_s) < 2e-14);
  }
}

TEST_CASE("the exact top reproduces published values over the whole time in one step") {
  const auto reproduces = [](Vec3<Quad> L, Quad t_s, const reference_values::Values& values, double bar) {
    const Vec3<Quad> g{Quad(5) / 3, Quad(5) / 4, 1};
    const auto value = [&](int i) { return parse_wide(values.at_end[i]); };
    const Top<Quad> truth{{value(0), value(1), value(2)}, {value(3), value(4), value(5), value(6)}};
    const Top<Quad> start{L, {}};
    CHECK(apart(turned(g, t_s, start), truth) < bar);
    Top<Quad> stepped = start;
    for (int k = 0; k < 37; ++k) stepped = turned(g, t_s / 37, stepped);
    CHECK(apart(stepped, truth) < bar);
  };
  reproduces({Quad(9) / 5, Quad(2) / 5, Quad(-9) / 10}, 10, reference_values::asymmetric_top, 1e-28);
  reproduces({Quad(6) / 10000, Quad(4) / 5, Quad(1) / 1000}, 100, reference_values::dzhanibekov, 1e-23);
}

// How much of a relative change of the state in the last places of S is left at the end, by the flow itself in quad.
double condition(const Vec3<Quad>& g, Quad t_s, const Top<Quad>& start) {
  double worst = 1;
  const Top<Quad> end = turned(g, t_s, start);
  const Quad e = Quad(1e-20L);
  for (int i = 0; i < 3; ++i) {
    Top<Quad> near = start;
    (&near.L.x)[i] += e * norm(start.L);
    worst = std::max(worst, apart(turned(g, t_s, near), end) / 1e-20);
  }
  return worst;
}

template <class S> void check_round_off() {
  for (const Case& c : cases()) {
    Vec3<S> g, L;
    for (int i = 0; i < 3; ++i) {
      (&g.x)[i] = S(1) / S(c.moments[i]);
      (&L.x)[i] = S(c.moments[i]) * S(c.w[i]);
    }
    if (norm(L) == S(0)) continue;
    const Vec3<Quad> wide_g = cast<S, Quad>(g);
    const Top<Quad> wide{cast<S, Quad>(L), {}};
    for (const double t_s : {1e-6, 0.01, 1.0, 12.5}) {
      INFO(c.name << " over " << t_s << " s, epsilon " << static_cast<double>(real::epsilon<S>()));
      const double round = static_cast<double>(real::epsilon<S>()) * condition(wide_g, t_s, wide);
      const double turns = 1 + t_s * static_cast<double>(norm(L)) / 0.5;  // the clock's own round-off
      CHECK(apart(turned(g, S(t_s), Top<S>{L, {}}), turned(wide_g, Quad(S(t_s)), wide)) < 30 * round * turns);
    }
  }
}

TEST_CASE("the exact top errs by round-off times the condition of its flow, in each scalar") {
  check_round_off<float>();
  check_round_off<double>();
  check_round_off<long double>();
}

// h L^ = F J - J F^T with J = tr(I) / 2 - I, the equation that makes it this top and no other of order 2.
TEST_CASE("a step of the discrete Lagrangian top solves its equation") {
  const Vec3<Quad> I{Quad(6) / 10, Quad(8) / 10, 1}, L{Quad(18) / 10, Quad(4) / 10, Quad(-9) / 10};
  const Quad h = Quad(1) / 10, J[3] = {(I.y + I.z - I.x) / 2, (I.z + I.x - I.y) / 2, (I.x + I.y - I.z) / 2};
  FreeTurn<Quad> turn;
  REQUIRE(implicit_turn(FreeTop::moser_veselov, I, h, L, turn));
  const Quat<Quad> q{1 + turn.minus_one.w, turn.minus_one.x, turn.minus_one.y, turn.minus_one.z};
  Vec3<Quad> column[3];
  for (int k = 0; k < 3; ++k) {
    Vec3<Quad> e;
    (&e.x)[k] = 1;
    column[k] = rotate(q, e);
  }
  const auto F = [&](int i, int k) { return (&column[k].x)[i]; };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    CHECK(std::fabs(static_cast<double>(F(k, j) * J[j] - J[k] * F(j, k) - h * (&L.x)[i])) < 1e-31);
  }
}

TEST_CASE("every top keeps the angular momentum in the world to round-off; all but the splittings energy too") {
  for (const char* scheme :
       {"free-top2", "free-top4", "free-top6", "moser-veselov", "implicit-midpoint-so3", "jacobi2", "jacobi4"}) {
    Scene scene = free_box(false);
    scene.bodies[0].inertia_kg_m2 = {0.6, 0.02, 0.01, 0.02, 0.8, -0.03, 0.01, -0.03, 1.0};
    const RigidModel<double> model(scene);
    const auto kept = [&](const BodySample& s) {
      const Quat<double> q{double(s.q_wxyz[0]), double(s.q_wxyz[1]), double(s.q_wxyz[2]), double(s.q_wxyz[3])};
      const Vec3<double> w{double(s.w_rad_per_s[0]), double(s.w_rad_per_s[1]), double(s.w_rad_per_s[2])};
      const Vec3<double> L = model.mass(0).times_inertia(w);
      return std::pair{rotate(q, L), dot(L, w)};
    };
    const Recorded r = run(scheme, scene, {20, 2000, 20});
    const auto [L, H] = kept(r.samples[0].bodies[0]);
    double worst_L = 0, worst_H = 0;
    for (const Sample& sample : r.samples) {
      const auto [L_now, H_now] = kept(sample.bodies[0]);
      worst_L = std::max(worst_L, norm(L_now - L) / norm(L));
      worst_H = std::max(worst_H, std::fabs(H_now - H) / H);
    }
    INFO(scheme << ": L " << worst_L << ", H " << worst_H);
    CHECK(worst_L < 1e-13);
    if (std::string(scheme).rfind("free-top", 0) != 0) CHECK(worst_H < 2e-13);
    else CHECK(worst_H > 1e-13);
  }
}

}  // namespace
}  // namespace atwood::testing
