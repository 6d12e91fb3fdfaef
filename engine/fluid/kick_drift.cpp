#include "fluid/kick_drift.hpp"

#include <algorithm>
#include <vector>

#include "integrators/compensation.hpp"
#include "integrators/compositions.hpp"

namespace atwood::fluid {
namespace {

const Composition* composition_of(const std::string& scheme) {
  if (scheme == "velocity-verlet") return find_composition("leapfrog-kdk");
  if (scheme == "leapfrog") return find_composition("leapfrog-dkd");
  return find_composition(scheme);
}

bool is_symmetric(const std::vector<Substep>& substeps) {
  const std::size_t last = substeps.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const Substep &a = substeps[i], &b = substeps[last - i];
    if (a.kick != b.kick || a.direct + a.adjoint != b.direct + b.adjoint) return false;
  }
  return true;
}

template <class S> class ParticleKickDrift final : public Stepper<S> {
 public:
  ParticleKickDrift(ParticleSystem<S>& particles, const std::vector<Substep>& substeps, const Lattice& lattice,
                    bool compensated)
      : Stepper<S>(particles.system()), particles_(particles), x_lattice_(S(lattice.position_m)),
        v_lattice_(S(lattice.velocity_m_per_s)), compensation_(compensated, particles.system().size),
        acceleration_(particles.layout().velocities()) {
    S elapsed{};
    for (const Substep& substep : substeps) {
      const S fraction = S(substep.direct + substep.adjoint);
      parts_.push_back({substep.kick, fraction, elapsed});
      if (!substep.kick) elapsed += fraction;
    }
  }

  bool step(S t_s, S h_s, const S* y, S* y_new) override {
    std::copy(y, y + this->system_.size, y_new);
    compensation_.begin(y);
    const int scalars = particles_.layout().velocities();  // of the positions, and of the velocities
    S* const x = y_new + particles_.layout().positions();
    S* const v = y_new + particles_.layout().velocities();
    for (std::size_t n = 0; n < parts_.size(); ++n) {
      const Part& part = parts_[n];
      const S h = part.fraction * h_s;
      if (part.kick) {
        // The first kick of a step that begins where the last one ended is by the forces of that one's last kick.
        if (n > 0 || !ends_at(y)) particles_.accelerations(t_s + part.elapsed * h_s, y_new, acceleration_.data());
        add(scalars, particles_.layout().velocities(), h, acceleration_.data(), v_lattice_, v);
      } else {
        add(scalars, particles_.layout().positions(), h, v, x_lattice_, x);
      }
    }
    compensation_.end(y_new);
    if (parts_.back().kick && parts_.front().kick) last_end_.assign(y_new, y_new + this->system_.size);
    this->set_last_step(t_s, h_s, y, y_new);
    return true;
  }

 private:
  struct Part {
    bool kick;
    S fraction, elapsed;
  };
  bool ends_at(const S* y) const { return !last_end_.empty() && std::equal(last_end_.begin(), last_end_.end(), y); }
  void add(int count, int first, S h, const S* rate, S lattice, S* sum) {
    for (int i = 0; i < count; ++i) {
      const S change = h * rate[i];
      sum[i] = compensation_.add(first + i, sum[i], lattice > S(0) ? on_lattice(change, lattice) : change);
    }
  }

  ParticleSystem<S>& particles_;
  S x_lattice_, v_lattice_;
  Compensation<S> compensation_;
  std::vector<S> acceleration_, last_end_;
  std::vector<Part> parts_;
};

}  // namespace

bool is_kick_drift(const std::string& scheme) { return composition_of(scheme) != nullptr; }

template <class S> S on_lattice(S value, S spacing) {
  const S steps = real::floor(real::abs(value) / spacing + S(0.5)) * spacing;
  return value < S(0) ? -steps : steps;
}

template <class S>
Result<std::unique_ptr<Stepper<S>>> make_kick_drift(const std::string& scheme, ParticleSystem<S>& particles,
                                                    const Lattice& lattice, bool compensated) {
  const Composition* composition = composition_of(scheme);
  if (composition == nullptr)
    return Fault{"atwood/" + scheme + " is not a kick-drift method (leapfrog or a composition of it)"};
  if (const std::string why = particles.not_separable(); !why.empty()) return Fault{"atwood/" + scheme + " " + why};
  const std::vector<Substep> substeps = composition->substeps();
  if (lattice.position_m > 0 && !is_symmetric(substeps))
    return Fault{"atwood/" + scheme + " is not symmetric; reversible=true requires a symmetric method"};
  if (lattice.position_m > 0 && compensated) return Fault{"reversible=true and compensated=true exclude each other"};
  return std::unique_ptr<Stepper<S>>(std::make_unique<ParticleKickDrift<S>>(particles, substeps, lattice, compensated));
}

#define ATWOOD_KICK_DRIFT(S)                                                                              \
  template S on_lattice<S>(S, S);                                                                         \
  template Result<std::unique_ptr<Stepper<S>>> make_kick_drift<S>(const std::string&, ParticleSystem<S>&, \
                                                                  const Lattice&, bool);
ATWOOD_KICK_DRIFT(float)
ATWOOD_KICK_DRIFT(double)
ATWOOD_KICK_DRIFT(long double)
ATWOOD_KICK_DRIFT(Quad)
#undef ATWOOD_KICK_DRIFT

}  // namespace atwood::fluid
