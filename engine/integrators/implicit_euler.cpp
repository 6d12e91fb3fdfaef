#include "integrators/implicit_euler.hpp"

namespace atwood {

template <class S>
ImplicitEuler<S>::ImplicitEuler(System<S>& system) : Stepper<S>(system), solver_(system.size), rate_(system.size) {}

template <class S> bool ImplicitEuler<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const auto rate = [](void* system, S t, const S* z, S* g) { static_cast<System<S>*>(system)->rate(t, z, g); };
  rate(&this->system_, t_s, y, rate_.data());  // first guess: explicit Euler
  for (int i = 0; i < this->system_.size; ++i) y_new[i] = y[i] + h_s * rate_[i];
  const bool solved = solver_.solve(rate, &this->system_, t_s + h_s, h_s, y, y_new);
  this->system_.project(y_new);
  this->remember(t_s, h_s, y, y_new);
  return solved;
}

template class ImplicitEuler<float>;
template class ImplicitEuler<double>;
template class ImplicitEuler<long double>;
template class ImplicitEuler<Quad>;

}  // namespace atwood
