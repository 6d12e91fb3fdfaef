#include <algorithm>

#include "integrators/partitioned.hpp"

namespace atwood {

//   v_new = v + h a(t, x, v)
//   x_new = x + h v_new
template <class S> bool SymplecticEuler<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + this->system_.size, y_new);
  kicker_.explicit_kick(t_s, h_s, y_new);
  drift(model_, h_s, FreeTop::lie, y_new);
  this->system_.project(y_new);
  this->remember(t_s, h_s, y, y_new);
  return true;
}

template class SymplecticEuler<float>;
template class SymplecticEuler<double>;
template class SymplecticEuler<long double>;
template class SymplecticEuler<Quad>;

}  // namespace atwood
