// The linear oscillator, damped and driven, m x'' = -k (x - a) - c x' + m g + F cos(w t + phi).
// Landau and Lifshitz, Mechanics, sections 21, 22, 25, 26.
#include "closed_form/entire.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Oscillator {
  S gamma{}, omega2{};      // x'' + 2 gamma x' + omega2 x = ...
  Vec<S> anchor{}, rest{};  // equilibrium position
  Vec<S> x0{}, v0{};        // relative to the equilibrium
  struct Driven {
    Vec<S> push{};
    S w{}, phase{};
  };
  std::vector<Driven> drives;  // push cos(w t + phase), an acceleration

  // Fundamental solutions: C(0) = 1, C'(0) = 0; s(0) = 0, s'(0) = 1.
  CenterMotion<S> homogeneous(const Vec<S>& x, const Vec<S>& v, S t) const {
    const S frequency = sqrt(omega2), y = (gamma - frequency) * (gamma + frequency) * t * t;
    S ch, sh;
    if (y > 1) {  // overdamped: slow and fast exponential, the slow rate without cancellation
      const S beta = sqrt(y) / t, slow = omega2 / (gamma + beta), fast = gamma + beta;
      ch = (exp(-slow * t) + exp(-fast * t)) / 2;
      sh = (exp(-slow * t) - exp(-fast * t)) / (2 * beta);
    } else {
      const S decay = exp(-gamma * t);
      ch = decay * cosh_root(y);
      sh = decay * t * sinhc_root(y);
    }
    return {(ch + gamma * sh) * x + sh * v, (ch - gamma * sh) * v - (omega2 * sh) * x};
  }

  // x_p = Re[push exp(i (w t + phase)) / (omega2 - w^2 + 2 i gamma w)]; at undamped resonance push t sin(.) / (2 w).
  CenterMotion<S> particular(const Driven& drive, S t) const {
    const S frequency = sqrt(omega2), re = (frequency - drive.w) * (frequency + drive.w), im = 2 * gamma * drive.w;
    const S square = re * re + im * im, c = cos(drive.w * t + drive.phase), s = sin(drive.w * t + drive.phase);
    if (square == 0) {
      const S half = 1 / (2 * drive.w);
      return {(half * t * s) * drive.push, (half * (s + drive.w * t * c)) * drive.push};
    }
    return {((re * c + im * s) / square) * drive.push, (drive.w * (im * c - re * s) / square) * drive.push};
  }

  CenterMotion<S> at(S t) const {
    Vec<S> x = x0, v = v0, xp{}, vp{};
    for (const Driven& drive : drives) {
      const CenterMotion<S> first = particular(drive, S(0)), now = particular(drive, t);
      x = x - first.p;
      v = v - first.v;
      xp = xp + now.p;
      vp = vp + now.v;
    }
    const CenterMotion<S> free = homogeneous(x, v, t);
    return {rest + free.p + xp, free.v + vp};
  }

  // Bound of the excursion from the equilibrium: |x| <= envelope of the free part plus the driven amplitudes.
  S reach() const {
    Vec<S> x = x0, v = v0;
    S driven = 0;
    for (const Driven& drive : drives) {
      const CenterMotion<S> first = particular(drive, S(0));
      x = x - first.p;
      v = v - first.v;
      const S re = omega2 - drive.w * drive.w, im = 2 * gamma * drive.w, size = sqrt(re * re + im * im);
      driven += size == 0 ? S(std::numeric_limits<double>::infinity()) : norm(drive.push) / size;
    }
    return sqrt(dot(x, x) + dot(v, v) / omega2) + driven;
  }
};

template <class S> bool along(const Vec<S>& line, const Vec<S>& v) { return is_zero(cross(line, v)); }

template <class S> std::string gather(const Scene& scene, int body, Oscillator<S>& made, const Spring*& spring) {
  const Body& bob = scene.bodies[body];
  const S mass = bob.mass_kg;
  S linear = 0;
  Vec<S> constant = vec<S>(scene.gravity_m_per_s2);
  for (const Force& force : scene.forces) {
    if (!acts_on(force, body)) continue;
    if (const auto* s = std::get_if<Spring>(&force); s && spring == nullptr && s->bodies.size() == 1) {
      spring = s;
      for (const Real3& point : s->points_body_m)
        if (point != Real3{})
          return force_on_body(scene, force, body) + " acts at a point other than its centre, which is not covered";
    } else if (const auto* drag = std::get_if<LinearDrag>(&force)) {
      linear += S(drag->coefficient_kg_per_s);
      constant = constant + (S(drag->coefficient_kg_per_s) / mass) * vec<S>(drag->wind_m_per_s);
    } else if (const auto* drive = std::get_if<Drive>(&force)) {
      made.drives.push_back(
          {(1 / mass) * vec<S>(drive->force_N), S(drive->angular_frequency_rad_per_s), S(drive->phase_rad)});
    } else {
      return force_on_body(scene, force, body) + " is not covered";
    }
  }
  if (spring == nullptr) return "expected a spring with an anchor on `" + bob.name + "`; found none";
  if (!(spring->stiffness_N_per_m > 0)) return "the spring of `" + bob.name + "` has no stiffness";
  if (!made.drives.empty() && bob.release_s > 0) return "`" + bob.name + "` is driven and released late";
  made.omega2 = S(spring->stiffness_N_per_m) / mass;
  made.gamma = (S(spring->damping_N_s_per_m) + linear) / (2 * mass);
  made.anchor = vec<S>(spring->anchor_m);
  made.rest = made.anchor + (1 / made.omega2) * constant;
  return "";
}

// Along a line through the anchor the spring is linear whatever its rest length and damping; off it only an undamped
// spring without rest length is (drag is, in every direction).
template <class S> Translation<S> oscillator_translation(const Scene& scene, int body) {
  const Body& bob = scene.bodies[body];
  Oscillator<S> made;
  const Spring* spring = nullptr;
  if (const std::string refusal = gather(scene, body, made, spring); !refusal.empty()) return {refusal, {}};
  // Beside resonance the driven and the free part are large and cancel; at it exactly the formula is another one.
  for (const auto& drive : made.drives) {
    const S frequency = sqrt(made.omega2), re = (frequency - drive.w) * (frequency + drive.w),
            im = 2 * made.gamma * drive.w, size = sqrt(re * re + im * im);
    if (size != 0 && size < S(0x1p-20) * made.omega2)
      return {"`" + bob.name + "` is driven within 2^-20 of its resonance, but not at it", {}};
  }
  const Vec<S> start = vec<S>(bob.position_m), v = vec<S>(bob.velocity_m_per_s), out = start - made.anchor;
  const S length0 = spring->rest_length_m;
  if (length0 != 0 || spring->damping_N_s_per_m != 0) {
    Vec<S> line = is_zero(out) ? v : out;
    if (is_zero(line)) line = made.rest - made.anchor;
    for (const auto& drive : made.drives)
      if (is_zero(line)) line = drive.push;
    bool straight = along(line, out) && along(line, v) && along(line, made.rest - made.anchor);
    for (const auto& drive : made.drives) straight &= along(line, drive.push);
    if (!straight) return {"`" + bob.name + "` leaves its line, and its spring has a rest length or damping", {}};
    if (length0 != 0) {
      if (is_zero(out)) return {"`" + bob.name + "` starts on the anchor of a spring with a rest length", {}};
      made.rest = made.rest + (length0 / norm(out)) * out;
    }
  }
  made.x0 = start - made.rest;
  made.v0 = v;
  if (length0 != 0 && !(dot(made.rest - made.anchor, out) > made.reach() * norm(out)))
    return {"`" + bob.name + "` may reach the anchor of a spring with a rest length", {}};
  return {"", [=](S t) { return made.at(t); }};
}

template <class S> Motion<S> solve_oscillator(const Scenario& scenario, const std::vector<S>& t_s) {
  return solve_each_body<S>(scenario, t_s, oscillator_translation<S>);
}

}  // namespace

Solution oscillator() {
  return {"oscillator",
          "linear oscillator, damped and driven, Landau and Lifshitz, Mechanics, sections 21-26",
          feature::kFreeMotion | feature::spring | feature::linear_drag_force | feature::angular_drag | feature::drive,
          solve_oscillator<Narrow>,
          solve_oscillator<Wide>,
          true};
}

}  // namespace atwood::closed_form
