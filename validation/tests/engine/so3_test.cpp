// Rotations and their generators, elliptic functions: against series, differences and another library, in each scalar.
#include "math/so3.hpp"

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <boost/math/special_functions/ellint_rj.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <catch2/catch.hpp>
#include <random>

#include "math/elliptic.hpp"

namespace atwood {
namespace {

template <class S> double size(const Vec3<S>& v) { return static_cast<double>(norm(v)); }

struct Draws {
  std::mt19937_64 random{20};
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  template <class S> Vec3<S> direction() {
    Vec3<S> v{S(in(-1, 1)), S(in(-1, 1)), S(in(-1, 1))};
    return (S(1) / norm(v)) * v;
  }
};

// sum_k [s]^k x / (k + shift)!
template <class S> Vec3<S> series(const Vec3<S>& s, Vec3<S> x, int shift) {
  Vec3<S> sum = x;
  for (int k = 1; k < 120; ++k) {
    x = (S(1) / S(k + shift)) * cross(s, x);
    sum += x;
  }
  return sum;
}

template <class S> void check_so3() {
  Draws draws;
  const double round = 64 * static_cast<double>(real::epsilon<S>());
  for (const double angle : {0.0, 1e-30, 1e-9, 1e-5, 1e-3, 0.1, 0.7, 1.9, 2.1, 3.0, 3.1415, 4.5, 6.0}) {
    const Vec3<S> n = draws.direction<S>(), x = draws.direction<S>();
    const Vec3<S> s = S(angle) * n;
    INFO("angle " << angle << ", epsilon " << static_cast<double>(real::epsilon<S>()));
    const double series_round = round * std::exp(angle) / 8;  // its terms grow to e^angle before they cancel
    CHECK(size(rotate(so3_exp(s), x) - series(s, x, 0)) < series_round);
    CHECK(size(left_jacobian(s, x) - series(s, x, 1)) < series_round);
    CHECK(size(inverse_left_jacobian(s, left_jacobian(s, x)) - x) < 20 * round);
    const Quat<S> minus_one = so3_exp_minus_one(s);
    CHECK(std::fabs(static_cast<double>(minus_one.w + S(2) * real::sin(S(angle) / S(4)) *
                                                          real::sin(S(angle) / S(4)))) <= round * angle * angle / 8);
    if (angle > 3.14) continue;
    const Quat<S> q = so3_exp(s), opposite{-q.w, -q.x, -q.y, -q.z};
    CHECK(size(so3_log(q) - s) <= round * angle);
    CHECK(size(so3_log(opposite) - s) <= round * angle);
  }
}

TEST_CASE("SO(3): exponential, logarithm, left Jacobian, without cancellation at any angle") {
  check_so3<float>();
  check_so3<double>();
  check_so3<long double>();
  check_so3<Quad>();
}

// exp(s)' exp(s)^-1 = J s' along s + e x: a difference quotient in quad.
TEST_CASE("the left Jacobian is the derivative of the exponential") {
  Draws draws;
  for (int k = 0; k < 20; ++k) {
    const Vec3<Quad> s = Quad(draws.in(0, 6)) * draws.direction<Quad>(), x = draws.direction<Quad>();
    const Quad e = 1e-12;
    const Vec3<Quad> turn = so3_log(so3_exp(s + e * x) * conjugate(so3_exp(s - e * x)));
    CHECK(size((1 / (2 * e)) * turn - left_jacobian(s, x)) < 1e-20);
  }
}

template <class S> void check_elliptic(double tolerance) {
  Draws draws;
  for (int k = 0; k < 60; ++k) {
    const double complement = std::pow(10.0, draws.in(-8, 0));
    const double phi = draws.in(0.01, 1.57), c2 = std::cos(phi) * std::cos(phi), s2 = 1 - c2, d2 = c2 + complement * s2;
    const double n = draws.in(0, 1);
    CHECK(static_cast<double>(carlson_rf(S(c2), S(d2), S(1))) ==
          Approx(boost::math::ellint_rf(c2, d2, 1.0)).epsilon(tolerance));
    CHECK(static_cast<double>(carlson_rj(S(c2), S(d2), S(1), S(1 + n * s2))) ==
          Approx(boost::math::ellint_rj(c2, d2, 1.0, 1 + n * s2)).epsilon(tolerance));
    const JacobiFunctions<S> jacobi{S(complement)};
    CHECK(static_cast<double>(jacobi.quarter()) ==
          Approx(boost::math::ellint_rf(0.0, complement, 1.0)).epsilon(tolerance));
    const double u = draws.in(-1, 1) * static_cast<double>(jacobi.quarter()), modulus = std::sqrt(1 - complement);
    if (complement < 1e-3) continue;  // their modulus has lost its complement's digits
    double cn, dn;
    const double sn = boost::math::jacobi_elliptic(modulus, u, &cn, &dn);
    const auto f = jacobi.at(S(u));
    CHECK(std::fabs(static_cast<double>(f.sn) - sn) < 2 * tolerance / complement);
    CHECK(std::fabs(static_cast<double>(f.cn) - cn) < 2 * tolerance / complement);
    CHECK(std::fabs(static_cast<double>(f.dn) - dn) < 2 * tolerance / complement);
  }
}

TEST_CASE("Carlson's integrals and Jacobi's functions agree with Boost's") {
  check_elliptic<float>(1e-5);
  check_elliptic<double>(2e-14);
  check_elliptic<long double>(2e-14);
  check_elliptic<Quad>(2e-14);
  // The period is infinite for k' = 0: the arithmetic-geometric mean of 1 and 0 never ends.
  CHECK(std::isnan(JacobiFunctions<double>(0.0).quarter()));
}

TEST_CASE("Carlson's integrals of what is not finite are not finite") {
  const double infinite = std::numeric_limits<double>::infinity(), nan = std::nan("");
  for (const double x : {infinite, nan}) {
    CHECK_FALSE(std::isfinite(carlson_rf(x, 1.0, 1.0)));
    CHECK_FALSE(std::isfinite(carlson_rj(x, 1.0, 1.0, 1.0)));
    CHECK_FALSE(std::isfinite(carlson_rj(1.0, 1.0, 1.0, x)));
  }
  CHECK(std::isfinite(carlson_rf(0.0, 1e-300, 1e300)));
}

// What another library in double cannot judge: sn is the inverse of F, and its derivatives are products, in quad.
template <class S> void check_identities() {
  Draws draws;
  const double round = 200 * static_cast<double>(real::epsilon<S>());
  for (int k = 0; k < 60; ++k) {
    const S complement = S(std::pow(10.0, draws.in(-12, 0)));
    const JacobiFunctions<S> jacobi(complement);
    const S u = S(draws.in(0.001, 0.999)) * jacobi.quarter();
    const auto f = jacobi.at(u);
    INFO("k'^2 = " << static_cast<double>(complement) << ", u = " << static_cast<double>(u));
    CHECK(std::fabs(static_cast<double>(f.sn * f.sn + f.cn * f.cn - S(1))) < round);
    CHECK(std::fabs(static_cast<double>(f.dn * f.dn - f.cn * f.cn - complement * f.sn * f.sn)) < round);
    CHECK(std::fabs(static_cast<double>(f.sn * carlson_rf(f.cn * f.cn, f.dn * f.dn, S(1)) / u - S(1))) < round);
  }
  // R_J(x, x, x, x) = x^(-3/2)
  CHECK(static_cast<double>(carlson_rj(S(4), S(4), S(4), S(4))) == Approx(0.125).epsilon(round));
}

TEST_CASE("Jacobi's functions invert Carlson's integral to round-off in each scalar") {
  check_identities<float>();
  check_identities<double>();
  check_identities<long double>();
  check_identities<Quad>();
}

// int_0^u N sn^2 / (1 + N sn^2) by Gauss's rule on panels, in quad, against R_J.
TEST_CASE("R_J is the integral it stands for, in quad") {
  const Quad complement = Quad(1) / 7000, N = Quad(3) / 10;
  const JacobiFunctions<Quad> jacobi(complement);
  const Quad u = jacobi.quarter() * Quad(0.9);
  const Quad node[3] = {-real::sqrt(Quad(3) / 5), 0, real::sqrt(Quad(3) / 5)};
  const Quad weight[3] = {Quad(5) / 18, Quad(8) / 18, Quad(5) / 18};
  const auto by = [&](int panels) {
    Quad sum = 0;
    for (int i = 0; i < panels; ++i)
      for (int j = 0; j < 3; ++j) {
        const Quad s = jacobi.at((Quad(i) + (1 + node[j]) / 2) * u / panels).sn;
        sum += weight[j] * N * s * s / (1 + N * s * s);
      }
    return sum * u / panels;
  };
  const auto f = jacobi.at(u);
  const Quad closed = N * f.sn * f.sn * f.sn * carlson_rj(f.cn * f.cn, f.dn * f.dn, Quad(1), 1 + N * f.sn * f.sn) / 3;
  const Quad fine = by(400), coarse = by(200);  // order 6: one step of extrapolation leaves 1e-18
  CHECK(std::fabs(static_cast<double>(fine + (fine - coarse) / 63 - closed)) < 1e-15);
}

}  // namespace
}  // namespace atwood
