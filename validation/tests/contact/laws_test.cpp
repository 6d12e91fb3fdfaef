// Impact laws: what must hold for any two bodies, and the path of the slip against a plain integration of it.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "contact/impulse.hpp"
#include "math/quat.hpp"

using namespace atwood;
using V = Vec3<double>;

namespace {

struct Meeting {
  double mass[2];
  V I[2];  // principal moments
  Quat<double> q[2];
  V r[2], v[2], w[2];
  V n;
};

using Draw = std::function<double()>;

V vector(const Draw& any) { return {any(), any(), any()}; }
V unit(const Draw& any) {
  for (;;) {
    const V v = vector(any);
    if (norm(v) > 0.1) return (1 / norm(v)) * v;
  }
}

// Moments that obey the triangle inequality: of a cloud with the given mean squares.
Meeting any_meeting(const Draw& any) {
  Meeting m;
  for (int i = 0; i < 2; ++i) {
    m.mass[i] = std::pow(10.0, any());
    const double x = std::pow(10.0, any()), y = std::pow(10.0, any()), z = std::pow(10.0, any());
    m.I[i] = 0.1 * m.mass[i] * V{y + z, z + x, x + y};
    m.q[i] = normalised(Quat<double>{1.5 + any(), any(), any(), any()});
    m.r[i] = vector(any);
    m.v[i] = 3.0 * vector(any);
    m.w[i] = 3.0 * vector(any);
  }
  m.n = unit(any);
  return m;
}

ImpactBody<double> side(const Meeting& m, int i) {
  ImpactBody<double> b;
  b.inverse_mass_per_kg = 1 / m.mass[i];
  const V axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int k = 0; k < 3; ++k) {
    const V at = rotate_back(m.q[i], axes[k]);
    b.I_inverse_W_row[k] = rotate(m.q[i], V{at.x / m.I[i].x, at.y / m.I[i].y, at.z / m.I[i].z});
  }
  b.r_W = m.r[i];
  b.v_W = m.v[i];
  b.w_W = m.w[i];
  return b;
}

V spin(const Meeting& m, int i, const V& w) {
  const V at = rotate_back(m.q[i], w);
  return rotate(m.q[i], V{m.I[i].x * at.x, m.I[i].y * at.y, m.I[i].z * at.z});
}

double kinetic(const Meeting& m, const ImpactBody<double>& a, const ImpactBody<double>& b) {
  return 0.5 * (m.mass[0] * dot(a.v_W, a.v_W) + m.mass[1] * dot(b.v_W, b.v_W) + dot(a.w_W, spin(m, 0, a.w_W)) +
                dot(b.w_W, spin(m, 1, b.w_W)));
}

struct Met {
  ImpactBody<double> a, b;
  Impulse<double> impulse;
  double energy_before, energy_after;
};
Met meet(const Meeting& m, const ImpactLaw<double>& law) {
  Met met{side(m, 0), side(m, 1), {}, 0, 0};
  met.energy_before = kinetic(m, met.a, met.b);
  met.impulse = collide(law, m.n, met.a, met.b);
  met.energy_after = kinetic(m, met.a, met.b);
  return met;
}

ImpactLaw<double> any_law(const Draw& any, Restitution hypothesis) {
  const double friction[] = {0, 0.05, 0.3, 1, 3, 30};
  return {0.5 * (1 + any()), friction[std::min(5, static_cast<int>(3 * (1 + any())))], 0, hypothesis};
}

Draw uniform(std::uint32_t seed) {
  auto random = std::make_shared<std::mt19937>(seed);
  return [random] { return std::uniform_real_distribution<double>(-1, 1)(*random); };
}

double worst(const V& a, const V& b) { return norm(a - b); }

}  // namespace

TEST_CASE(
    "any impact: momentum to round-off, friction in its cone, energy never up under Poisson's and Stronge's laws") {
  CHECK(rc::check("conservation and dissipation", [] {
    const Draw any = uniform(*rc::gen::arbitrary<std::uint32_t>());
    for (const Restitution hypothesis : {Restitution::newton, Restitution::poisson, Restitution::stronge}) {
      const Meeting m = any_meeting(any);
      ImpactLaw<double> law = any_law(any, hypothesis);
      if (*rc::gen::inRange(0, 3) == 0) law.rolling_friction_m = 0.1;
      if (*rc::gen::inRange(0, 3) == 0) law.restitution = 1;
      const Met met = meet(m, law);
      if (!(met.impulse.vn_before_m_per_s < 0)) continue;
      const V dp0 = m.mass[0] * (met.a.v_W - m.v[0]), dp1 = m.mass[1] * (met.b.v_W - m.v[1]);
      const double size = norm(dp0) + met.impulse.normal_N_s;
      RC_ASSERT(norm(dp0 + dp1) < 1e-13 * size + 1e-14 * (m.mass[0] * norm(m.v[0]) + m.mass[1] * norm(m.v[1])));
      // about the common point: r x dp (from the point to the centre, -r) + dL = 0, together
      const V dL =
          spin(m, 0, met.a.w_W - m.w[0]) + spin(m, 1, met.b.w_W - m.w[1]) + cross(-m.r[0], dp0) + cross(-m.r[1], dp1);
      const double spins =
          norm(spin(m, 0, m.w[0])) + norm(spin(m, 1, m.w[1])) + m.mass[0] * norm(m.v[0]) + m.mass[1] * norm(m.v[1]);
      RC_ASSERT(norm(dL) < 1e-12 * (size + spins));
      RC_ASSERT(met.impulse.normal_N_s > 0);
      const double tangential = norm(dp1 - dot(dp1, m.n) * m.n);
      RC_ASSERT(tangential <= law.friction * met.impulse.normal_N_s * (1 + 1e-11) + 1e-13 * (size + spins));
      if (hypothesis == Restitution::newton) {
        if (law.rolling_friction_m == 0)
          RC_ASSERT(std::abs(met.impulse.vn_after_m_per_s + law.restitution * met.impulse.vn_before_m_per_s) <
                    1e-11 * (norm(m.v[0]) + norm(m.v[1]) + norm(m.w[0]) + norm(m.w[1])));
      } else {
        RC_ASSERT(met.energy_after <= met.energy_before * (1 + 1e-12));
      }
    }
  }));
}

TEST_CASE(
    "Newton's law can gain energy in eccentric impacts with friction; the other two did not on the same meetings") {
  const Draw any = uniform(11);
  int gained = 0, met_count = 0;
  double most = 0;
  for (int i = 0; i < 20000; ++i) {
    const Meeting m = any_meeting(any);
    ImpactLaw<double> law{0.9, 0.5, 0, Restitution::newton};
    const Met newton = meet(m, law);
    if (!(newton.impulse.vn_before_m_per_s < 0)) continue;
    ++met_count;
    const double gain = newton.energy_after / newton.energy_before - 1;
    gained += gain > 1e-9;
    most = std::max(most, gain);
    law.hypothesis = Restitution::poisson;
    REQUIRE(meet(m, law).energy_after <= newton.energy_before * (1 + 1e-12));
    law.hypothesis = Restitution::stronge;
    REQUIRE(meet(m, law).energy_after <= newton.energy_before * (1 + 1e-12));
  }
  WARN("Newton's law at e = 0.9, mu = 0.5: " << gained << " of " << met_count
                                             << " random impacts gained energy, at most by a factor " << 1 + most);
  CHECK(gained > 10);
  CHECK(most > 1e-3);
}

TEST_CASE("swapping the bodies, turning or moving the world changes an impact by round-off alone") {
  CHECK(rc::check("symmetries", [] {
    const Draw any = uniform(*rc::gen::arbitrary<std::uint32_t>());
    for (const Restitution hypothesis : {Restitution::newton, Restitution::poisson, Restitution::stronge}) {
      const Meeting m = any_meeting(any);
      ImpactLaw<double> law = any_law(any, hypothesis);
      const Met plain = meet(m, law);
      // The worst bodies here have inertia ratios of 1e4 and impulses over 100 times what they change, hence 1e-10.
      const double size =
          norm(m.v[0]) + norm(m.v[1]) + norm(m.w[0]) + norm(m.w[1]) + norm(plain.a.w_W) + norm(plain.b.w_W);

      Meeting swapped = m;
      std::swap(swapped.mass[0], swapped.mass[1]);
      std::swap(swapped.I[0], swapped.I[1]);
      std::swap(swapped.q[0], swapped.q[1]);
      std::swap(swapped.r[0], swapped.r[1]);
      std::swap(swapped.v[0], swapped.v[1]);
      std::swap(swapped.w[0], swapped.w[1]);
      swapped.n = -m.n;
      const Met other = meet(swapped, law);
      RC_ASSERT(worst(other.a.v_W, plain.b.v_W) + worst(other.b.v_W, plain.a.v_W) + worst(other.a.w_W, plain.b.w_W) <
                1e-10 * size);

      const Quat<double> turn = normalised(Quat<double>{any(), any(), any(), 1.1 + any()});
      const V drift = vector(any);
      Meeting moved = m;
      for (int i = 0; i < 2; ++i) {
        moved.q[i] = turn * m.q[i];
        moved.r[i] = rotate(turn, m.r[i]);
        moved.v[i] = rotate(turn, m.v[i]) + drift;
        moved.w[i] = rotate(turn, m.w[i]);
      }
      moved.n = rotate(turn, m.n);
      const Met turned = meet(moved, law);
      RC_ASSERT(worst(turned.a.v_W, rotate(turn, plain.a.v_W) + drift) +
                    worst(turned.b.w_W, rotate(turn, plain.b.w_W)) <
                1e-10 * size);
    }
  }));
}

TEST_CASE("slip that turns: against the hodograph taken in a million plain steps") {
  // dJ/dp = n - mu u_t / |u_t|, explicit midpoint in p, to where v_n = 0 and on to 1 + e times that impulse.
  const Draw any = uniform(5);
  int turned = 0;
  for (int i = 0; i < 60 && turned < 6; ++i) {
    const Meeting m = any_meeting(any);
    const double mu = 0.25, e = 0.6;
    ImpactBody<double> a = side(m, 0), b = side(m, 1);
    const V u0 = relative_velocity(a, b);
    if (!(dot(u0, m.n) < 0)) continue;
    const Met met = meet(m, {e, mu, 0, Restitution::poisson});
    const V slip_after = relative_velocity(met.a, met.b) - dot(relative_velocity(met.a, met.b), m.n) * m.n;
    const V slip_before = u0 - dot(u0, m.n) * m.n;
    if (norm(slip_after) < 0.05 * norm(slip_before))
      continue;  // slips to the end: the plain steps need no case for stick
    const double cosine = dot(slip_after, slip_before) / norm(slip_after) / norm(slip_before);
    if (cosine > 0.95) continue;
    ++turned;
    const int steps = 400000;
    const double dp = met.impulse.normal_N_s / steps;
    double p_compression = 0;
    const auto direction = [&](const ImpactBody<double>& x, const ImpactBody<double>& y) {
      const V u = relative_velocity(x, y), t = u - dot(u, m.n) * m.n;
      return m.n - (mu / norm(t)) * t;
    };
    double vn = dot(u0, m.n);
    for (int k = 0; k < steps; ++k) {
      ImpactBody<double> half_a = a, half_b = b;
      apply_impulse(half_a, half_b, direction(a, b), dp / 2);
      apply_impulse(a, b, direction(half_a, half_b), dp);
      const double next = dot(relative_velocity(a, b), m.n);
      if (vn < 0 && next >= 0) p_compression = dp * (k + vn / (vn - next));
      vn = next;
    }
    CHECK(p_compression * (1 + e) == Approx(met.impulse.normal_N_s).epsilon(1e-8));
    CHECK(worst(a.v_W, met.a.v_W) + worst(b.w_W, met.b.w_W) < 1e-8);
  }
  CHECK(turned >= 3);
}

TEST_CASE("a leaning rod on a rough floor: slip that reverses, by Routh's construction") {
  // In the plane, x along the floor, z up: K = [[Kxx, Kxz], [Kxz, Kzz]], all of it straight lines in p.
  const double m = 1, half = 0.5, I = m * half * half / 3, angle = 0.9, mu = 0.35, e = 0.5;
  const V r{-half * std::cos(angle), 0, -half * std::sin(angle)};  // from the centre to the end that touches
  const double Kxx = 1 / m + r.z * r.z / I, Kzz = 1 / m + r.x * r.x / I, Kxz = -r.x * r.z / I;
  ImpactBody<double> floor, rod;
  rod.inverse_mass_per_kg = 1 / m;
  rod.I_inverse_W_row[0] = {1 / (1e-3 * I), 0, 0};
  rod.I_inverse_W_row[1] = {0, 1 / I, 0};
  rod.I_inverse_W_row[2] = {0, 0, 1 / I};
  rod.r_W = r;
  const double ux = 0.2, uz = -2;
  rod.v_W = {ux, 0, uz};
  REQUIRE(std::abs(Kxz) / Kxx > mu);  // friction cannot hold once slip has stopped: it reverses
  const double p_stop = ux / (mu * Kxx - Kxz * 1.0);
  REQUIRE(p_stop > 0);
  const double uz_stop = uz + p_stop * (Kzz - mu * Kxz);
  REQUIRE(uz_stop < 0);
  const double slope = Kzz + (Kxz < 0 ? mu : -mu) * Kxz;  // against the slip that sets in along K_tn
  const double p_c = p_stop - uz_stop / slope;
  const double W_c = (uz + uz_stop) / 2 * p_stop + uz_stop / 2 * (p_c - p_stop);
  double p_end = 0;
  Restitution hypothesis{};
  SECTION("newton") {
    hypothesis = Restitution::newton;
    p_end = p_c - e * uz / slope;
  }
  SECTION("poisson") {
    hypothesis = Restitution::poisson;
    p_end = (1 + e) * p_c;
  }
  SECTION("stronge") {
    hypothesis = Restitution::stronge;
    p_end = p_c + e * std::sqrt(-2 * W_c / slope);
  }
  const Impulse<double> impulse = collide<double>({e, mu, 0, hypothesis}, {0, 0, 1}, floor, rod);
  CHECK(impulse.normal_N_s == Approx(p_end).epsilon(1e-13));
  const double j_x = -mu * p_stop + (Kxz < 0 ? mu : -mu) * (p_end - p_stop);
  CHECK(rod.v_W.x == Approx(ux + j_x / m).epsilon(1e-13));
  CHECK(impulse.vn_after_m_per_s == Approx(uz_stop + slope * (p_end - p_stop)).epsilon(1e-12));
}

TEST_CASE("rolling friction slows a ball's roll at a bounce, up to stopping it") {
  const double m = 2, r = 0.1, I = 0.4 * m * r * r, vz = -3, e = 0.5;
  ImpactBody<double> floor, ball;
  ball.inverse_mass_per_kg = 1 / m;
  for (int i = 0; i < 3; ++i) ball.I_inverse_W_row[i] = {i == 0 ? 1 / I : 0, i == 1 ? 1 / I : 0, i == 2 ? 1 / I : 0};
  ball.r_W = {0, 0, -r};
  ball.v_W = {1, 0, vz};
  ball.w_W = {0, 1 / r, 0};  // it rolls
  const double J = -(1 + e) * vz * m;
  SECTION("a little: it keeps rolling, slower by the couple about the touching point") {
    const double delta = 1e-3;
    collide<double>({e, 10, delta, Restitution::newton}, {0, 0, 1}, floor, ball);
    CHECK(ball.w_W.y == Approx(1 / r - delta * J / (I + m * r * r)).epsilon(1e-12));
    CHECK(ball.v_W.x == Approx(r * ball.w_W.y).epsilon(1e-12));
  }
  SECTION("much: it stops") {
    collide<double>({e, 10, 1, Restitution::newton}, {0, 0, 1}, floor, ball);
    CHECK(std::abs(ball.w_W.y) < 1e-12);
    CHECK(std::abs(ball.v_W.x) < 1e-12);
  }
}
