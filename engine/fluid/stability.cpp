#include "fluid/stability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "fluid/kick_drift.hpp"
#include "integrators/catalogue.hpp"
#include "protocol/sample.hpp"

namespace atwood::fluid {
namespace {

constexpr int kTrialSteps = 256, kWaves = 8;
constexpr double kNone = std::numeric_limits<double>::infinity();

struct StepBounds {  // of all effects together and of each alone; infinite: none; 0: no step is stable
  double all_s = 0, sound_s = 0, viscosity_s = 0, heat_s = 0, force_s = 0;
};

struct Symbol {
  double G, L;
};

// Waves of lengths down to two spacings along the first axis and the diagonal.
std::vector<Symbol> symbols(const Kernel<double>& kernel, double spacing) {
  const int d = kernel.dimensions, cells = static_cast<int>(std::ceil(kernel.support / spacing));
  const double pi = std::acos(-1.0), volume = std::pow(spacing, d);
  std::vector<Symbol> found;
  for (const bool diagonal : {false, true})
    for (int wave = 1; wave <= kWaves; ++wave) {
      const double k = pi * wave / (kWaves * spacing);
      double sine = 0, cosine = 0;
      for (int a = -cells; a <= cells; ++a)
        for (int b = -cells; b <= cells; ++b)
          for (int c = d == 3 ? -cells : 0; c <= (d == 3 ? cells : 0); ++c) {
            const double phase = k * spacing * (diagonal ? a + b + c : a);
            const double F = kernel.slope_over_distance(spacing * std::sqrt(double(a * a + b * b + c * c)));
            sine += volume * F * spacing * a * std::sin(phase);
            cosine += volume * F * (1 - std::cos(phase));
          }
      found.push_back({std::abs(sine) * (diagonal ? std::sqrt(double(d)) : 1), -2 * cosine});
    }
  return found;
}

struct Modes {
  std::vector<Symbol> symbols;
  ModeRates rates;
  static constexpr int unknowns = 4;  // a, q, transverse, thermal

  static void rate_of(void* context, double, const double* y, double* dydt) {
    const Modes& self = *static_cast<Modes*>(context);
    const ModeRates& r = self.rates;
    for (std::size_t n = 0; n < self.symbols.size(); ++n, y += unknowns, dydt += unknowns) {
      const auto& [G, L] = self.symbols[n];
      dydt[0] = -r.sound_speed_m_per_s * G * y[1] - r.longitudinal_m2_per_s * L * y[0];
      dydt[1] = r.sound_speed_m_per_s * G * y[0] - r.density_m2_per_s * L * y[1];
      dydt[2] = -r.transverse_m2_per_s * L * y[2];
      dydt[3] = -r.thermal_m2_per_s * L * y[3];
    }
  }
};

// Kicks and drifts of a wave: position and velocity, x' = v, v' = -(c G)^2 x.
class Waves final : public ParticleSystem<double> {
 public:
  Waves(const Modes& modes) : modes_(modes) {
    layout_.dimensions = 1;
    layout_.particles = static_cast<int>(modes.symbols.size());
    system_.size = layout_.size();
  }
  const std::string& unsupported() const override { return none_; }
  const Layout& layout() const override { return layout_; }
  System<double>& system() override { return system_; }
  void initial_state(double*) const override {}
  void write(double, const double*, Sample&) override {}
  std::string fault(const double*) const override { return ""; }
  std::string not_separable() const override { return ""; }
  void accelerations(double, const double* y, double* a) override {
    for (int i = 0; i < layout_.particles; ++i) {
      const double w = modes_.rates.sound_speed_m_per_s * modes_.symbols[i].G;
      a[i] = -w * w * y[i];
    }
  }

 private:
  const Modes& modes_;
  Layout layout_;
  System<double> system_;
  std::string none_;
};

// Does no wave grow by more than its share of a tenth over the run?
bool stable(const std::string& scheme, const Settings& overrides, const std::vector<Symbol>& all,
            const ModeRates& rates, double h_s, std::int64_t steps) {
  Modes modes{all, rates};
  const double most = 1 + 0.1 * std::min(1.0, double(kTrialSteps) / double(steps));
  std::vector<double> y, next;
  std::unique_ptr<Stepper<double>> stepper;
  System<double> system;
  Waves waves(modes);
  const int count = static_cast<int>(all.size());
  if (is_kick_drift(scheme)) {
    // A symmetric method does not keep the size of a wave from step to step: below the limit it stays within a factor,
    // beyond it grows exponentially.
    auto made = make_kick_drift<double>(scheme, waves, {}, false);
    if (!made) return true;
    stepper = std::move(*made);
    y.assign(2 * count, 1.0);
    for (int i = 0; i < count; ++i) y[count + i] = rates.sound_speed_m_per_s * all[i].G;
  } else {
    system.size = Modes::unknowns * count;
    system.context = &modes;
    system.rate_of = Modes::rate_of;
    auto made = make_stepper<double>(scheme, system, overrides);
    if (!made) return true;  // refused elsewhere, by name
    stepper = std::move(*made);
    y.assign(system.size, 1.0);
  }
  next = y;
  for (int n = 0; n < kTrialSteps; ++n) {
    if (!stepper->step(n * h_s, h_s, y.data(), next.data())) return true;
    y.swap(next);
  }
  if (!is_kick_drift(scheme)) {
    for (int i = 0; i < count; ++i) {  // two waves a symbol: longitudinal, and the damped ones
      double* const at = &y[std::size_t(i) * Modes::unknowns];
      if (!(std::hypot(at[0], at[1]) <= most * std::sqrt(2.0)) || !(std::abs(at[2]) <= most) ||
          !(std::abs(at[3]) <= most))
        return false;
    }
    return true;
  }
  for (int i = 0; i < count; ++i) {
    const double w = rates.sound_speed_m_per_s * all[i].G;
    if (!(std::abs(y[i]) <= 100 && std::abs(y[count + i]) <= 100 * w + 1e-300)) return false;
  }
  return true;
}

// The largest step up to which is_stable(h_s) holds, to 2^-20 of a bracket of a factor of 1.5: a fixed number of
// halvings. `fastest`: rate of the fastest mode [1/s].
template <class Stable> double largest_stable(double fastest, const Stable& is_stable) {
  if (fastest == 0) return kNone;
  double low = 1e-6 / fastest, high = low;
  if (!is_stable(low)) return 0;
  while (high < 1e3 / fastest && is_stable(high)) low = high, high *= 1.5;
  if (high >= 1e3 / fastest) return kNone;
  for (int n = 0; n < 20; ++n) {
    const double middle = std::sqrt(low * high);
    (is_stable(middle) ? low : high) = middle;
  }
  return low;
}

// How many steps of h_s a run over t_end_s has. A wave's share of growth depends on it: explicit Euler's method, which
// lets every undamped oscillation grow, is stable up to steps proportional to 1 / t_end_s.
std::int64_t steps_over(double t_end_s, double h_s) {
  return static_cast<std::int64_t>(std::clamp(std::ceil(t_end_s / h_s), 1.0, 1e15));
}

double largest_stable(const std::string& scheme, const Settings& overrides, const std::vector<Symbol>& all,
                      const ModeRates& rates, double t_end_s) {
  double fastest = 0;
  for (const Symbol& symbol : all)
    fastest = std::max({fastest, rates.sound_speed_m_per_s * symbol.G,
                        symbol.L * std::max({rates.longitudinal_m2_per_s, rates.transverse_m2_per_s,
                                             rates.thermal_m2_per_s, rates.density_m2_per_s})});
  return largest_stable(
      fastest, [&](double h_s) { return stable(scheme, overrides, all, rates, h_s, steps_over(t_end_s, h_s)); });
}

// Modes of given eigenvalues, each as the real system a' = re a - im b, b' = im a + re b.
void rate_of_modes(void* context, double, const double* y, double* dydt) {
  for (const std::complex<double>& lambda : *static_cast<const std::vector<std::complex<double>>*>(context)) {
    dydt[0] = lambda.real() * y[0] - lambda.imag() * y[1];
    dydt[1] = lambda.imag() * y[0] + lambda.real() * y[1];
    y += 2, dydt += 2;
  }
}

bool stable(const std::string& scheme, const Settings& overrides, std::vector<std::complex<double>>& eigenvalues,
            double h_s, std::int64_t steps) {
  System<double> system;
  system.size = 2 * static_cast<int>(eigenvalues.size());
  system.context = &eigenvalues;
  system.rate_of = rate_of_modes;
  auto stepper = make_stepper<double>(scheme, system, overrides);
  if (!stepper) return true;  // refused elsewhere, by name
  std::vector<double> y(system.size, 1.0), next = y;
  for (int n = 0; n < kTrialSteps; ++n) {
    if (!(*stepper)->step(n * h_s, h_s, y.data(), next.data())) return true;
    y.swap(next);
  }
  const double share = std::min(1.0, double(kTrialSteps) / double(steps));
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    const double own_growth = std::max(0.0, eigenvalues[i].real()) * h_s * kTrialSteps;
    if (!(std::hypot(y[2 * i], y[2 * i + 1]) <= std::sqrt(2.0) * (1 + 0.1 * share) * std::exp(own_growth)))
      return false;
  }
  return true;
}

std::string seconds(double h_s) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g s", h_s);
  return digits;
}

std::string per_second(double rate) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g /s", rate);
  return digits;
}

// The fewest steps, a multiple of `samples`, with which the run is accepted: from the bound on, which the search knows
// to a part in a million.
template <class Accepted>
std::int64_t steps_needed(double t_end_s, double bound_s, std::int64_t samples, const Accepted& is_accepted) {
  constexpr int tries = 100;
  std::int64_t frame = (steps_over(t_end_s, bound_s) + samples - 1) / samples;  // steps between two samples
  for (int n = 0; n < tries; ++n) {
    const std::int64_t steps = frame * samples;
    if (is_accepted(t_end_s / static_cast<double>(steps), steps)) break;
    frame += 1 + frame / 1000;
  }
  return frame * samples;
}

// What a refusal says: the limit, what it comes from, and how many equal steps the run would need.
template <class Accepted>
std::string refusal(const std::string& scheme, double bound_s, const std::string& causes, const EqualSteps& asked,
                    const Accepted& is_accepted) {
  const std::string method = "atwood/" + scheme;
  if (bound_s == 0) return "no step of " + method + " is stable here (" + causes + ")";
  return "steps of " + seconds(asked.h_s) + " are beyond the stability limit of " + method + ", " + seconds(bound_s) +
         " (" + causes + "); the run needs at least " +
         std::to_string(steps_needed(asked.t_end_s(), bound_s, asked.samples, is_accepted)) + " equal steps";
}

std::string effects(const StepBounds& bounds) {
  std::string words;
  int found = 0;
  const auto add = [&](const char* effect, double bound) {
    if (bound == kNone) return;
    words += (words.empty() ? "" : ", by ") + std::string(effect) + " " + (bound == 0 ? "no step" : seconds(bound));
    ++found;
  };
  add("sound", bounds.sound_s);
  add("viscosity and diffusion of density", bounds.viscosity_s);
  add("conduction", bounds.heat_s);
  add("gravity", bounds.force_s);
  // A damped oscillation may be stable at longer steps than an undamped one: the limit of all may exceed one of these.
  return (found > 1 ? "of all effects together; each alone: by " : "by ") + words;
}

}  // namespace

std::string instability_message(const std::string& scheme, const Settings& overrides, const Kernel<double>& kernel,
                                double spacing_m, const ModeRates& rates, const EqualSteps& asked) {
  const std::vector<Symbol> all = symbols(kernel, spacing_m);
  StepBounds bounds;
  bounds.force_s = rates.gravity_m_per_s2 > 0
                       ? std::sqrt(kernel.support / support_ratio(kernel.shape) / rates.gravity_m_per_s2)
                       : kNone;
  const auto is_accepted = [&](double h_s, std::int64_t steps) {
    return h_s <= bounds.force_s && stable(scheme, overrides, all, rates, h_s, steps);
  };
  if (is_accepted(asked.h_s, asked.steps)) return "";
  const double t_end_s = asked.t_end_s();
  bounds.all_s = std::min(bounds.force_s, largest_stable(scheme, overrides, all, rates, t_end_s));
  bounds.sound_s = largest_stable(scheme, overrides, all, {rates.sound_speed_m_per_s}, t_end_s);
  ModeRates viscous, thermal;
  viscous.longitudinal_m2_per_s = rates.longitudinal_m2_per_s;
  viscous.transverse_m2_per_s = rates.transverse_m2_per_s;
  viscous.density_m2_per_s = rates.density_m2_per_s;
  thermal.thermal_m2_per_s = rates.thermal_m2_per_s;
  bounds.viscosity_s = largest_stable(scheme, overrides, all, viscous, t_end_s);
  bounds.heat_s = largest_stable(scheme, overrides, all, thermal, t_end_s);
  return refusal(scheme, bounds.all_s, effects(bounds), asked, is_accepted);
}

std::string instability_message(const std::string& scheme, const Settings& overrides,
                                const std::vector<std::complex<double>>& eigenvalues, const EqualSteps& asked) {
  if (eigenvalues.empty()) return "";
  std::vector<std::complex<double>> all = eigenvalues;
  double highest = 0;
  for (const std::complex<double>& lambda : eigenvalues) highest = std::max(highest, std::abs(lambda.imag()));
  for (int wave = 1; wave < kWaves; ++wave) all.push_back({0, highest * wave / kWaves});
  const auto is_accepted = [&](double h_s, std::int64_t steps) { return stable(scheme, overrides, all, h_s, steps); };
  if (is_accepted(asked.h_s, asked.steps)) return "";
  std::complex<double> fastest = 0;
  double oscillating = 0, decaying = 0;
  for (const std::complex<double>& lambda : all) {
    if (std::abs(lambda) > std::abs(fastest)) fastest = lambda;
    oscillating = std::max(oscillating, std::abs(lambda.imag()));
    decaying = std::max(decaying, -lambda.real());
  }
  const double bound =
      largest_stable(std::abs(fastest), [&](double h_s) { return is_accepted(h_s, steps_over(asked.t_end_s(), h_s)); });
  return refusal(scheme, bound,
                 "fastest oscillation " + per_second(oscillating) + ", fastest decay " + per_second(decaying), asked,
                 is_accepted);
}

}  // namespace atwood::fluid
