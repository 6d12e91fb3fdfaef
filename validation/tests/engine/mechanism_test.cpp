// Mechanisms in the coordinates of their joints: two ways to the same accelerations, conserved quantities, composites.
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "joints/mass_matrix.hpp"
#include "joints/planar_rates.hpp"
#include "mechanisms.hpp"
#include "scene/files.hpp"

namespace atwood::testing {
namespace {

template <class S> struct Evaluated {
  RigidModel<S> model;
  std::vector<S> y, dydt;
  explicit Evaluated(const Scene& scene) : model(scene) {
    INFO(model.unsupported());
    REQUIRE(model.unsupported().empty());
    y.resize(model.state_size());
    dydt.resize(model.state_size());
    model.initial_state(y.data());
    model.system().rate(S(0), y.data(), dydt.data());
    move_tree();
  }
  // The tree's kinematics and accelerations at y, which rates may leave as they were.
  void move_tree() {
    Sample sample;
    model.write(S(0), y.data(), sample);
  }
};

double size_of(Quad x) { return static_cast<double>(real::abs(x)); }

// Gauss's elimination with row pivots of n equations.
std::vector<Quad> solved(std::vector<Quad> M, std::vector<Quad> b) {
  const int n = static_cast<int>(b.size());
  for (int c = 0; c < n; ++c) {
    int pivot = c;
    for (int r = c + 1; r < n; ++r)
      if (real::abs(M[r * n + c]) > real::abs(M[pivot * n + c])) pivot = r;
    for (int k = 0; k < n; ++k) std::swap(M[c * n + k], M[pivot * n + k]);
    std::swap(b[c], b[pivot]);
    for (int r = c + 1; r < n; ++r) {
      const Quad factor = M[r * n + c] / M[c * n + c];
      for (int k = c; k < n; ++k) M[r * n + k] -= factor * M[c * n + k];
      b[r] -= factor * b[c];
    }
  }
  for (int r = n - 1; r >= 0; --r) {
    for (int k = r + 1; k < n; ++k) b[r] -= M[r * n + k] * b[k];
    b[r] /= M[r * n + r];
  }
  return b;
}

// ---- the algorithm against the composite-rigid-body matrix ----------------------------------------------------------
TEST_CASE("articulated bodies accelerate as the composite mass matrix says, in quad") {
  double worst = 0, worst_solve = 0;
  int rates = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Scene scene = random_tree(seed, 12);
    Evaluated<Quad> e(scene);
    Tree<Quad> tree(
        scene,
        [&] {
          std::vector<int> offsets;
          for (int i = 0; i < e.model.body_count(); ++i) offsets.push_back(e.model.offset(i));
          return offsets;
        }(),
        e.model.tree()->scalars_at());
    const int n = tree.rate_count();
    rates += n;
    tree.kinematics(Quad(0), e.y.data());
    std::vector<Load<Quad>> loads(scene.bodies.size());
    for (auto& load : loads) load.acceleration_W = narrow3<Quad>(scene.gravity_m_per_s2);
    // M u' + h = 0: h is what u' = 0 would ask of the joints.
    std::vector<Quad> zero(n, Quad(0)), minus_h(n), du(n), solve(n);
    tree.accelerate_bodies(zero.data());
    tree.reactions(loads.data(), nullptr);
    for (std::size_t i = 0; i < tree.links().size(); ++i)
      for (int k = tree.links()[i].first_rate; k < tree.links()[i].first_rate + tree.links()[i].rates; ++k)
        minus_h[k] = -dot(tree.column(k).s, tree.column(k).angular ? tree.motion(i).n : tree.motion(i).f);
    const std::vector<Quad> expected = solved(mass_matrix(tree), minus_h);
    tree.accelerations(loads.data(), nullptr, du.data());
    tree.solve(minus_h.data(), solve.data());
    double scale = 0;
    for (const Quad& x : expected) scale = std::max(scale, size_of(x));
    for (int k = 0; k < n; ++k) {
      worst = std::max(worst, size_of(du[k] - expected[k]) / scale);
      worst_solve = std::max(worst_solve, size_of(solve[k] - expected[k]) / scale);
      CHECK(size_of(e.dydt[tree.state_of_rate(k)] - expected[k]) <= 1e-28 * scale);
    }
  }
  CAPTURE(worst, worst_solve);
  CHECK(rates > 300);
  CHECK(worst < 1e-29);
  CHECK(worst_solve < 1e-29);
}

// The kinetic energy of bodies placed by other code (scene/mechanism.hpp), and their velocities along the Jacobian's
// rows.
TEST_CASE("the mass matrix and the Jacobian's rows agree with the placed bodies") {
  for (unsigned seed = 30; seed < 40; ++seed) {
    const Scene scene = random_tree(seed, 10);
    const MechanismStart start = mechanism_start(scene);
    Evaluated<Quad> e(scene);
    const Tree<Quad>& tree = *e.model.tree();
    const int n = tree.rate_count();
    const std::vector<Quad> M = mass_matrix(tree);
    std::vector<Quad> u(n);
    for (int k = 0; k < n; ++k) u[k] = e.y[tree.state_of_rate(k)];
    Quad twice = 0, expected = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) twice += u[i] * M[i * n + j] * u[j];
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].fixed) continue;
      const BodyMotion& b = start.bodies[i];
      for (int r = 0; r < 3; ++r) {
        expected += Quad(scene.bodies[i].mass_kg) * b.v_m_per_s[r] * b.v_m_per_s[r];
        for (int c = 0; c < 3; ++c)
          expected += b.w_rad_per_s[r] * Quad(scene.bodies[i].inertia_kg_m2[3 * r + c]) * b.w_rad_per_s[c];
      }
      const BodyState<Quad> state = e.model.body(static_cast<int>(i), e.y.data());
      for (int k = 0; k < 3; ++k) {
        CHECK(size_of((&state.p_WB.x)[k] - b.p_m[k]) < 1e-30);
        CHECK(size_of((&state.v_WB.x)[k] - b.v_m_per_s[k]) < 1e-29);
        CHECK(size_of((&state.w_WB_B.x)[k] - b.w_rad_per_s[k]) < 1e-29);
        std::vector<Quad> row(n, Quad(0));
        Vec3<Quad> along;
        (&along.x)[k] = 1;
        tree.add_wrench(static_cast<int>(i), state.p_WB, along, {}, row.data());
        Quad velocity = 0;
        for (int j = 0; j < n; ++j) velocity += row[j] * u[j];
        CHECK(size_of(velocity - b.v_m_per_s[k]) < 1e-29);
      }
    }
    CHECK(size_of(twice - expected) < 1e-28 * size_of(expected));
    CHECK(size_of(e.model.energy(e.y.data()) - twice / 2) > 1e-3);  // the potential
  }
}

// The bodies' accelerations are the rates of change of their velocities along the motion: central differences.
TEST_CASE("accelerations of bodies are the rates of their velocities") {
  const Scene scene = random_tree(50, 9);
  Evaluated<Quad> e(scene);
  const Tree<Quad>& tree = *e.model.tree();
  const int size = e.model.state_size();
  const Quad h = Quad(1) / 100000000;
  std::vector<Quad> y(size), rate(size);
  // y'' from two rates, so that y(+-h) is right to h^3.
  std::vector<Quad> second(size);
  for (int i = 0; i < size; ++i) y[i] = e.y[i] + h * e.dydt[i];
  e.model.system().rate(h, y.data(), rate.data());
  for (int i = 0; i < size; ++i) second[i] = (rate[i] - e.dydt[i]) / h;
  e.model.system().rate(Quad(0), e.y.data(), e.dydt.data());
  e.move_tree();
  struct Seen {
    Vec3<Quad> a, alpha;
  };
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const int b = static_cast<int>(i);
    const Vec3<Quad> at = tree.link_of(b) < 0 ? Vec3<Quad>{} : tree.centre_W(tree.link_of(b));
    seen.push_back({tree.acceleration_W(b, at), tree.angular_acceleration_W(b)});
  }
  std::vector<BodyState<Quad>> ends[2];
  for (const int side : {0, 1}) {
    const Quad t = side == 0 ? -h : h;
    for (int i = 0; i < size; ++i) y[i] = e.y[i] + t * e.dydt[i] + t * t / 2 * second[i];
    e.model.normalise(y.data());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      ends[side].push_back(e.model.body(static_cast<int>(i), y.data()));
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    const auto w = [&](int side) { return rotate(ends[side][i].q_WB, ends[side][i].w_WB_B); };
    const Vec3<Quad> a = (1 / (2 * h)) * (ends[1][i].v_WB - ends[0][i].v_WB), alpha = (1 / (2 * h)) * (w(1) - w(0));
    for (int k = 0; k < 3; ++k) {
      CHECK(size_of((&a.x)[k] - (&seen[i].a.x)[k]) < 1e-12);
      CHECK(size_of((&alpha.x)[k] - (&seen[i].alpha.x)[k]) < 1e-12);
    }
  }
}

// ---- reactions ---------------------------------------------------------------------------------------------------
// Newton and Euler for each body by itself: gravity, the reactions of all its joints, and what acts along them.
TEST_CASE("reactions and applied forces move each body by itself") {
  for (unsigned seed = 60; seed < 66; ++seed) {
    Scene scene = random_tree(seed, 10);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const int jointed = static_cast<int>(j);
      if (rate_count(scene.joints[j].kind) == 0) continue;
      scene.joint_forces.push_back(
          JointSpring{jointed, 0, scene.joints[j].kind == JointKind::ball ? 0 : 3.0, 0.2, 0.4});
      if (rate_count(scene.joints[j].kind) == 2) scene.joint_forces.push_back(JointTorque{jointed, 1, 1.7, 2, 0.3, {}});
    }
    Evaluated<Quad> e(scene);
    const Tree<Quad>& tree = *e.model.tree();
    Sample sample;
    e.model.write(Quad(0), e.y.data(), sample);
    std::vector<Vec3<Quad>> force(scene.bodies.size()), moment(scene.bodies.size());
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const JointSample& at = sample.joints[j];
      const Link<Quad>& link = tree.links()[tree.link_of_joint(static_cast<int>(j))];
      const LinkMotion<Quad>& m = tree.motion(tree.link_of_joint(static_cast<int>(j)));
      Vec3<Quad> f{at.force_N[0], at.force_N[1], at.force_N[2]},
          n{at.torque_N_m[0], at.torque_N_m[1], at.torque_N_m[2]};
      // Constraint forces do no work at any rates.
      for (int k = 0; k < link.rates; ++k) {
        const Column<Quad>& column = tree.column(link.first_rate + k);
        CHECK(size_of(dot(column.s, column.angular ? n : f)) < 1e-28);
      }
      if (joint.kind == JointKind::universal) {  // the pair of axes: what both feel
        const Vec3<Quad> a = tree.column(link.first_rate).s, b = tree.column(link.first_rate + 1).s;
        const Quad ab = dot(a, b), det = 1 - ab * ab;
        n += ((at.applied[0] - ab * at.applied[1]) / det) * a + ((at.applied[1] - ab * at.applied[0]) / det) * b;
      } else {
        for (int k = 0; k < link.rates; ++k) {
          const Column<Quad>& column = tree.column(link.first_rate + k);
          (column.angular ? n : f) += at.applied[k] * column.s;
        }
      }
      force[joint.child] += f;
      moment[joint.child] += n - cross(m.r, f);
      if (joint.parent < 0 || scene.bodies[joint.parent].fixed) continue;
      force[joint.parent] -= f;
      const Vec3<Quad> arm = m.A - tree.centre_W(tree.link_of(joint.parent));
      moment[joint.parent] -= n + cross(arm, f);
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].fixed) continue;
      const int b = static_cast<int>(i), l = tree.link_of(b);
      const Quad mass = scene.bodies[i].mass_kg;
      const Vec3<Quad> a = tree.acceleration_W(b, tree.centre_W(l)) - narrow3<Quad>(scene.gravity_m_per_s2);
      const Mat3<Quad>& R = tree.motion(l).R_WB;
      const Vec3<Quad> w = tree.motion(l).w, alpha = tree.motion(l).alpha;
      const auto I = [&](const Vec3<Quad>& v) { return R * e.model.mass(b).times_inertia(transposed_times(R, v)); };
      const Vec3<Quad> f = mass * a - force[i], n = I(alpha) + cross(w, I(w)) - moment[i];
      CHECK(size_of(norm(f)) < 1e-27);
      CHECK(size_of(norm(n)) < 1e-27);
    }
  }
}

// ---- in planes ---------------------------------------------------------------------------------------------------
// A tree on the world and on a tilted body: hinges along one normal or against it, sliders across it, welds.
Scene planar_tree(unsigned seed, int links) {
  std::mt19937 random(seed);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {1.5, -9, 2};
  const JointKind kinds[] = {JointKind::hinge, JointKind::hinge, JointKind::slider, JointKind::fixed};
  for (int i = 0; i < links; ++i) {
    scene.bodies.push_back(link("link." + std::to_string(i), real(0.5, 2), {0.25, real(0.125, 0.25), 0.25}));
    scene.bodies.back().inertia_kg_m2[1] = scene.bodies.back().inertia_kg_m2[3] = real(-0.03, 0.03);
    scene.bodies.back().inertia_kg_m2[5] = scene.bodies.back().inertia_kg_m2[7] = real(-0.03, 0.03);
    const int parent = i % 5 == 0 ? -1 : std::uniform_int_distribution<int>(i - i % 5, i - 1)(random);
    const JointKind kind = i % 5 == 0 ? JointKind::hinge : kinds[random() % 4];
    Joint made = joint("joint." + std::to_string(i), kind, parent, i, {real(-1, 1), real(-1, 1), real(-1, 1)},
                       {real(-1, 1), real(-1, 1), real(-1, 1)});
    if (kind == JointKind::slider) made.axis_body = i % 2 == 0 ? Real3{1, 0, 0} : Real3{0, -1, 0};
    // Quarter and half turns whose quaternions are exact: body axes stay along the world's.
    if (i % 3 == 1) made.frame_wxyz = {0, 1, 0, 0};
    if (i % 7 == 3) made.frame_wxyz = {0, 0, 1, 0};
    made.coordinates[0] = real(-3, 3);
    made.rates[0] = real(-2, 2);
    if (i % 11 == 4 && kind != JointKind::fixed) made.driven_rate = made.rates[0];
    scene.joints.push_back(made);
    if (kind != JointKind::fixed) scene.joint_forces.push_back(JointSpring{i, 0, real(0, 3), 0.3, real(0, 1)});
  }
  return placed(scene);
}

template <class S> double planar_difference(const Scene& scene) {
  RigidModel<S> model(scene);
  std::vector<S> y(model.state_size()), dydt(model.state_size());
  model.initial_state(y.data());
  model.system().rate(S(0.25), y.data(), dydt.data());  // in planes
  std::vector<int> offsets(scene.bodies.size(), -1);
  Tree<S> tree(scene, offsets, 0);
  REQUIRE(PlanarRates<S>::of(tree).has_value());
  tree.kinematics(S(0.25), y.data());
  std::vector<Load<S>> loads(scene.bodies.size());
  for (auto& load : loads) load.acceleration_W = narrow3<S>(scene.gravity_m_per_s2);
  std::vector<S> applied(tree.rate_count()), du(tree.rate_count());
  JointForces<S>(scene).add(tree, S(0.25), y.data(), applied.data());
  tree.accelerations(loads.data(), applied.data(), du.data());
  S most = S(0), scale = S(0);
  for (int k = 0; k < tree.rate_count(); ++k) {
    most = real::max(most, real::abs(du[k] - dydt[tree.state_of_rate(k)]));
    scale = real::max(scale, real::abs(du[k]));
  }
  return static_cast<double>(most / scale);
}

TEST_CASE("mechanisms in planes accelerate as in space") {
  double in_double = 0, in_quad = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    in_double = std::max(in_double, planar_difference<double>(planar_tree(seed, 20)));
    in_quad = std::max(in_quad, planar_difference<Quad>(planar_tree(seed, 20)));
  }
  CAPTURE(in_double, in_quad);
  CHECK(in_double < 1e-12);
  CHECK(in_quad < 1e-30);
}

TEST_CASE("mechanisms that leave their plane are not planar") {
  const auto is_planar = [](const Scene& scene) {
    std::vector<int> offsets(scene.bodies.size(), -1);
    return PlanarRates<double>::of(Tree<double>(scene, offsets, 0)).has_value();
  };
  Scene scene = hinge_chain({0.5, 0.2, 0.3});
  CHECK(is_planar(scene));
  Scene tilted = scene;
  tilted.joints[2].axis_body = {0, std::sin(1e-10), std::cos(1e-10)};
  CHECK_FALSE(is_planar(tilted));
  Scene across = scene;
  across.joints[2].kind = JointKind::slider;
  CHECK_FALSE(is_planar(across));
  across.joints[2].axis_body = {0.6, 0.8, 0};
  CHECK(is_planar(across));
  Scene ball = scene;
  ball.joints[1].kind = JointKind::ball;
  ball.joints[1].coordinates = {1, 0, 0, 0};
  CHECK_FALSE(is_planar(ball));
}

template <class S> void check_lanes(const Scene& scene, const char* what) {
  RigidModel<S> model(scene);
  INFO(what << " " << model.unsupported());
  REQUIRE(model.unsupported().empty());
  const int size = model.state_size();
  std::vector<S> first(static_cast<std::size_t>(size)), at(first), rate(first), scratch(2 * first.size());
  model.initial_state(first.data());
  const auto state = [&](int k, int i) { return first[static_cast<std::size_t>(i)] * S(1 + 0.01 * k * (i % 5)); };
  for (const VectorWidth width : {VectorWidth::narrow, VectorWidth::v3, VectorWidth::v4}) {
    if (width > widest_vectors()) continue;
    model.set_vector_width(width);
    for (const int count : {2, 3, 8, 11}) {
      std::vector<S> t_s, states(first.size() * static_cast<std::size_t>(count)), rates(states);
      for (int k = 0; k < count; ++k) {
        t_s.push_back(S(0.125) * S(k));
        for (int i = 0; i < size; ++i) states[static_cast<std::size_t>(i * count + k)] = state(k, i);
      }
      model.system().rates(count, t_s.data(), states.data(), rates.data(), scratch.data());
      int differ = 0;
      for (int k = 0; k < count; ++k) {
        for (int i = 0; i < size; ++i) at[static_cast<std::size_t>(i)] = state(k, i);
        model.system().rate(t_s[static_cast<std::size_t>(k)], at.data(), rate.data());
        for (int i = 0; i < size; ++i)
          differ += rates[static_cast<std::size_t>(i * count + k)] == rate[static_cast<std::size_t>(i)] ? 0 : 1;
      }
      CAPTURE(count, static_cast<int>(width));
      CHECK(differ == 0);
    }
  }
}

TEST_CASE("the rates of several states at once are those of each, to the last bit at any vector width") {
  for (unsigned seed = 77; seed < 83; ++seed) {
    check_lanes<double>(random_tree(seed, 8), "tree");
    check_lanes<float>(random_tree(seed, 8), "tree in float");
    check_lanes<double>(planar_tree(seed, 9), "tree in planes, springs, driven joints");
  }
  Scene far = hinge_chain({0.5, 0.2, 0.3});
  far.joints[1].coordinates[0] = 1e6;  // beyond the reduction of angles that lanes share
  check_lanes<double>(placed(far), "angle of many turns");
}

// ---- motion ---------------------------------------------------------------------------------------------------------
Scene tumbling() {
  Scene scene = random_tree(81, 8, false);
  for (Joint& joint : scene.joints)  // the first body carries all others, and is free
    if (joint.parent < 0 || scene.bodies[joint.parent].fixed) joint.parent = joint.child == 0 ? -1 : 0;
  std::erase_if(scene.joints, [](const Joint& joint) { return joint.child == 0; });
  scene.gravity_m_per_s2 = {};
  scene.bodies[0].velocity_m_per_s = {0.1, 0.2, -0.1};
  scene.bodies[0].angular_velocity_body_rad_per_s = {0.3, 0.5, -0.4};
  return placed(scene);
}

struct Momenta {
  std::array<Wide, 3> linear{}, angular{};
};
Momenta momenta(const Scene& scene, const Sample& sample) {
  Momenta total;
  Vec3<Quad> linear, angular;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    const BodySample& b = sample.bodies[i];
    const Real33& I = scene.bodies[i].inertia_kg_m2;
    const Vec3<Quad> p{b.p_m[0], b.p_m[1], b.p_m[2]}, v{b.v_m_per_s[0], b.v_m_per_s[1], b.v_m_per_s[2]};
    const auto& w = b.w_rad_per_s;
    const Vec3<Quad> L{I[0] * w[0] + I[1] * w[1] + I[2] * w[2], I[3] * w[0] + I[4] * w[1] + I[5] * w[2],
                       I[6] * w[0] + I[7] * w[1] + I[8] * w[2]};
    const Quat<Quad> q{b.q_wxyz[0], b.q_wxyz[1], b.q_wxyz[2], b.q_wxyz[3]};
    linear += Quad(scene.bodies[i].mass_kg) * v;
    angular += cross(p, Quad(scene.bodies[i].mass_kg) * v) + rotate(normalised(q), L);
  }
  total.linear = {linear.x, linear.y, linear.z};
  total.angular = {angular.x, angular.y, angular.z};
  return total;
}

TEST_CASE("a floating tree keeps its momenta and its energy at the method's order") {
  const Scene scene = tumbling();
  RigidModel<Quad> model(scene);
  const auto drift = [&](std::int64_t steps) {
    const Recorded r = run("rk4", scene, {1, steps, 1}, "quad");
    const Momenta start = momenta(scene, r.samples[0]), end = momenta(scene, r.samples[1]);
    return std::array<double, 2>{distance(start.linear, end.linear), distance(start.angular, end.angular)};
  };
  const auto coarse = drift(40), fine = drift(80);
  CAPTURE(coarse[0], coarse[1], fine[0], fine[1]);
  CHECK(std::log2(coarse[0] / fine[0]) == Approx(4).margin(0.4));
  CHECK(std::log2(coarse[1] / fine[1]) == Approx(4).margin(0.4));
  const Recorded r = run("gbs", scene, {1, 400, 1}, "quad");
  const Momenta start = momenta(scene, r.samples[0]), end = momenta(scene, r.samples[1]);
  CHECK(distance(start.linear, end.linear) < 1e-21);
  CHECK(distance(start.angular, end.angular) < 1e-21);
}

// The same bodies and joints in another order, and turned and moved: the same motion.
TEST_CASE("a chain moves alike in any order of its bodies and joints") {
  const Scene scene = hinge_chain({0.5, 0.2, -0.4, 0.9}, {0.1, 0, -0.3, 0.2});
  const Recorded plain = run("dop853", scene, {2, 200, 1}, "quad");
  Scene other = scene;
  const std::vector<int> at{2, 0, 3, 1};  // of body i
  for (int i = 0; i < 4; ++i) other.bodies[at[i]] = scene.bodies[i];
  for (int i = 0; i < 4; ++i) {
    Joint moved = scene.joints[i];
    moved.child = at[moved.child];
    if (moved.parent >= 0) moved.parent = at[moved.parent];
    other.joints[3 - i] = moved;
  }
  const Recorded shuffled = run("dop853", other, {2, 200, 1}, "quad");
  for (int i = 0; i < 4; ++i) {
    CHECK(distance(plain.samples[1].bodies[i].p_m, shuffled.samples[1].bodies[at[i]].p_m) < 1e-29);
    CHECK(size_of(plain.samples[1].joints[i].u[0] - shuffled.samples[1].joints[3 - i].u[0]) < 1e-29);
  }
}

// Two bodies welded together, tumbling under gravity: the free flight of the composite.
TEST_CASE("a welded pair moves as the composite body") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  scene.bodies.push_back(link("first", 2, {0.125, 0.25, 0.375}));
  scene.bodies.push_back(link("second", 2, {0.125, 0.25, 0.375}));
  scene.bodies[0].velocity_m_per_s = {1, 2, 3};
  scene.bodies[0].angular_velocity_body_rad_per_s = {0.5, 2, 0.25};
  scene.joints.push_back(joint("weld", JointKind::fixed, 0, 1, {1, 0, 0}, {-1, 0, 0}));
  scene = placed(scene);
  // Centre of mass 1 m from each body along x: moments 2 * 0.125, 2 * (0.25 + 2), 2 * (0.375 + 2); rate as each body's,
  // and the centre's velocity v + w x (1, 0, 0) = (1, 2 + 0.25, 3 - 2).
  Scene composite = empty_scene();
  composite.gravity_m_per_s2 = scene.gravity_m_per_s2;
  composite.bodies.push_back(link("both", 4, {0.25, 4.5, 4.75}));
  composite.bodies[0].position_m = {1, 0, 0};
  composite.bodies[0].velocity_m_per_s = {1, 2.25, 1};
  composite.bodies[0].angular_velocity_body_rad_per_s = {0.5, 2, 0.25};
  const BodySample both = run("dop853", composite, {2, 400, 1}, "quad").samples[1].bodies[0];
  const Sample pair = run("dop853", scene, {2, 400, 1}, "quad").samples[1];
  CHECK(attitude_distance(pair.bodies[0].q_wxyz, both.q_wxyz) < 1e-15);
  CHECK(attitude_distance(pair.bodies[1].q_wxyz, both.q_wxyz) < 1e-15);
  CHECK(distance(pair.bodies[0].w_rad_per_s, both.w_rad_per_s) < 1e-16);
  std::array<Wide, 3> centre{};
  for (int k = 0; k < 3; ++k) centre[k] = (pair.bodies[0].p_m[k] + pair.bodies[1].p_m[k]) / 2;
  CHECK(distance(centre, both.p_m) < 1e-20);
}

// A hinge whose other degrees of freedom are at rest is a pendulum: th'' = -m g l sin th / (I + m l^2).
TEST_CASE("driven joints follow their time, and their motor's torque is a reaction") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, -10, 0};
  scene.bodies.push_back(link("crank", 2, {0.1, 0.1, 0.2}));
  Joint crank = joint("crank", JointKind::hinge, -1, 0, {0, 0, 0}, {-0.5, 0, 0});
  crank.coordinates[0] = 0.25;
  crank.driven_rate = 3;
  scene.joints.push_back(crank);
  scene.joint_forces.push_back(JointSpring{0, 0, 4, 0, 0.5});
  scene = placed(scene);
  const Recorded r = run("rk4", scene, {2, 10, 2}, "quad");
  for (const Sample& sample : r.samples) {
    const Quad angle = Quad(0.25) + 3 * sample.t_s;
    const JointSample& at = sample.joints[0];
    CHECK(size_of(at.q[0] - angle) < 1e-32);
    CHECK(size_of(at.u[0] - 3) < 1e-32);
    // The motor balances gravity's moment and the spring: torque = m g l cos th - spring.
    const Quad spring = -4 * angle - Quad(0.5) * 3;
    CHECK(size_of(at.applied[0] - spring) < 1e-30);
    CHECK(size_of(at.torque_N_m[2] - (Quad(10) * real::cos(angle) - spring)) < 1e-29);
    // Inwards: m w^2 l.
    CHECK(size_of(at.force_N[0] + 9 * real::cos(angle)) < 1e-29);
    CHECK(size_of(at.force_N[1] - (20 - 9 * real::sin(angle))) < 1e-29);
  }
}

// ---- refusals -------------------------------------------------------------------------------------------------------
TEST_CASE("methods step mechanisms exactly where they claim an order") {
  const Scene scene = hinge_chain({0.5, 0.2});
  int steps = 0, refuses = 0;
  for (const MethodInfo& info : integrator_catalogue()) {
    const std::string scheme = info.id.substr(7);
    INFO(scheme);
    const Recorded r = try_run(scheme, scene, {0.1, 10, 1});
    if (info.claimed_order.contains("mechanism")) {
      CHECK(r.outcome.status == Status::ok);
      // RATTLE and Baumgarte's stabilisation step nothing else.
      if (const auto claim = info.claimed_order.find("rotation"); claim != info.claimed_order.end())
        CHECK(info.claimed_order.at("mechanism") == claim->second);
      ++steps;
    } else {
      CHECK(r.outcome.status == Status::unsupported);
      CHECK(r.outcome.reason.find("cannot step a mechanism") != std::string::npos);
      CHECK(r.outcome.reason.find(scheme) != std::string::npos);
      ++refuses;
    }
  }
  CHECK(steps == 56);
  CHECK(refuses == 36);
}

// Of its first step, which has no prediction, the changes of alternate sweeps grow once on their way to round-off.
TEST_CASE("radau15 solves the first step of a rope of twenty links") {
  const Scenario rope = read_scenario(std::string(ATWOOD_SOURCE_DIR) + "/validation/scenarios/rope-20-balls.toml");
  for (const int steps : {240, 1280}) {
    const Outcome outcome = atwood_engine().run(parse_method_id("atwood/radau15"), rope.scene, {10, steps, 1}, {}, 0);
    INFO(outcome.reason);
    CHECK(outcome.status == Status::ok);
    CHECK(outcome.solvers.at("implicit-stages").capped == 0);
  }
}

TEST_CASE("what a tree cannot be is refused by name") {
  const Scene good = hinge_chain({0.5, 0.2});
  const auto reason = [&](auto&& change) {
    Scene scene = good;
    change(scene);
    const Recorded r = try_run("rk4", scene, {0.1, 10, 1});
    CHECK(r.outcome.status == Status::unsupported);
    return r.outcome.reason;
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(reason([](Scene& s) { s.bodies[1].inertia_kg_m2 = {}; }), Contains("point mass `link.1`"));
  CHECK_THAT(reason([](Scene& s) { s.joints[0].parent = 1; }), Contains("lead back"));
  CHECK_THAT(reason([](Scene& s) { s.joints[0].child = 1; }), Contains("`link.1` is placed by two joints"));
  CHECK_THAT(reason([](Scene& s) { s.bodies[1].release_s = 1; }),
             Contains("release_s is not supported for bodies on joints: `link.1`"));
  CHECK_THAT(reason([](Scene& s) {
               s.bodies.push_back(link("wall", 0, {}));
               s.bodies.back().fixed = true;
               s.bodies.back().velocity_m_per_s = {1, 0, 0};
               s.joints[0].parent = 2;
             }),
             Contains("`wall` has a velocity"));
}

}  // namespace
}  // namespace atwood::testing
