// What a run of fluids steps: a flat state with its rate, its start and its samples. `+sph` and `+polynomial` are two.
#pragma once

#include <string>

#include "fluid/layout.hpp"
#include "math/system.hpp"
#include "parallel/team.hpp"
#include "protocol/sample.hpp"

namespace atwood::fluid {

// A system of particles as a run steps it.
template <class S> class ParticleSystem {
 public:
  virtual ~ParticleSystem() = default;
  // Why the engine cannot run this scene with these settings; empty: it can. Nothing else may be called then.
  virtual const std::string& unsupported() const = 0;
  virtual const Layout& layout() const = 0;
  virtual System<S>& system() = 0;
  virtual void initial_state(S* y) const = 0;
  virtual void write(S t_s, const S* y, Sample& sample) = 0;
  // Empty: the state is sound. Else which particle is lost or not finite, and how.
  virtual std::string fault(const S* y) const = 0;
  // The part of fault() that a run asks for after every step, with y finite: a particle that went through a wall, or
  // bodies that overlap.
  virtual std::string lost(S /*t_s*/, const S* /*y*/) { return ""; }

  // Why the system is not separable (x' = v, v' = a(x)), as kicks and drifts need; empty: it is.
  virtual std::string not_separable() const { return "has no kicks and drifts"; }
  virtual Team* team() { return nullptr; }  // the threads that share the rates; null: one alone
  virtual void accelerations(S /*t_s*/, const S* /*y*/, S* /*acceleration*/) {}  // d numbers a particle
};

}  // namespace atwood::fluid
