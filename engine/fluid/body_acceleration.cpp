#include "fluid/body_acceleration.hpp"

namespace atwood::fluid {
namespace {

// A function of (t, x) at a point: its value, time derivative, gradient and Laplacian.
template <class S, int d> struct Jet {
  S value{}, rate{}, slope[d]{}, laplacian{};

  friend Jet operator+(const Jet& a, const Jet& b) {
    Jet sum{a.value + b.value, a.rate + b.rate, {}, a.laplacian + b.laplacian};
    for (int c = 0; c < d; ++c) sum.slope[c] = a.slope[c] + b.slope[c];
    return sum;
  }
  friend Jet operator*(S a, const Jet& b) {
    Jet product{a * b.value, a * b.rate, {}, a * b.laplacian};
    for (int c = 0; c < d; ++c) product.slope[c] = a * b.slope[c];
    return product;
  }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + S(-1) * b; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet product{a.value * b.value, a.rate * b.value + a.value * b.rate, {}, {}};
    product.laplacian = a.value * b.laplacian + b.value * a.laplacian;
    for (int c = 0; c < d; ++c) {
      product.slope[c] = a.slope[c] * b.value + a.value * b.slope[c];
      product.laplacian += S(2) * a.slope[c] * b.slope[c];
    }
    return product;
  }
};

// sin(k x) and cos(k x) of one axis.
template <class S, int d> void waves(S k, S x, int axis, Jet<S, d>& sine, Jet<S, d>& cosine) {
  S s, c;
  real::sin_cos(k * x, s, c);
  sine = {s, {}, {}, -k * k * s};
  cosine = {c, {}, {}, -k * k * c};
  sine.slope[axis] = k * c;
  cosine.slope[axis] = -k * s;
}

// The velocity over U cos(wt), and the density over rho0, less 1, over its amplitude.
template <class S> void field(const Jet<S, 2> (&s)[2], const Jet<S, 2> (&c)[2], Jet<S, 2> (&v)[2], Jet<S, 2>& rise) {
  v[0] = s[0] * c[1];
  v[1] = S(-1) * (c[0] * s[1]);
  rise = s[0] * s[1];
}
template <class S> void field(const Jet<S, 3> (&s)[3], const Jet<S, 3> (&c)[3], Jet<S, 3> (&v)[3], Jet<S, 3>& rise) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    v[i] = s[i] * (c[k] * s[j] * s[j] - c[j] * s[k] * s[k]);
  }
  rise = s[0] * s[1] * s[2];
}

}  // namespace

template <class S> BodyAcceleration<S>::BodyAcceleration(const Fluid& fluid) : law_(make_law<S>(fluid)) {
  if (fluid.source.name.empty()) return;
  const auto of = [&](const char* name) { return S(fluid.source.parameters.at(name)); };
  dimensions_ = fluid.source.name == "mms-2d" ? 2 : 3;
  wave_number_ = S(2) * real::atan2(S(0), S(-1)) * of("mode") / of("length_m");
  speed_ = of("speed_m_per_s");
  angular_frequency_ = of("angular_frequency_rad_per_s");
  density_amplitude_ = of("density_amplitude");
}

// s = dv/dt + (v . grad) v + (p'(rho) / rho) grad rho - nu (rho0 / rho) lap v
template <class S> template <int d> void BodyAcceleration<S>::add_in(S t_s, const S* x, S* to) const {
  using J = Jet<S, d>;
  J sine[d], cosine[d], v[d], rise;
  for (int c = 0; c < d; ++c) waves<S, d>(wave_number_, x[c], c, sine[c], cosine[c]);
  field(sine, cosine, v, rise);
  S sine_t, cosine_t;
  real::sin_cos(angular_frequency_ * t_s, sine_t, cosine_t);
  const J swing{speed_ * cosine_t, -speed_ * angular_frequency_ * sine_t, {}, {}};
  for (int c = 0; c < d; ++c) v[c] = swing * v[c];
  const J density = law_.density0 * (J{S(1), {}, {}, {}} + density_amplitude_ * rise);
  const S push = law_.pressure_slope(density.value) / density.value, drag = law_.viscosity / density.value;
  for (int c = 0; c < d; ++c) {
    to[c] += v[c].rate + push * density.slope[c] - drag * v[c].laplacian;
    for (int a = 0; a < d; ++a) to[c] += v[a].value * v[c].slope[a];
  }
}

template <class S> void BodyAcceleration<S>::add(S t_s, const S* x, S* to) const {
  if (dimensions_ == 2) add_in<2>(t_s, x, to);
  else if (dimensions_ == 3) add_in<3>(t_s, x, to);
}

template class BodyAcceleration<float>;
template class BodyAcceleration<double>;
template class BodyAcceleration<long double>;
template class BodyAcceleration<Quad>;

}  // namespace atwood::fluid
