#include <algorithm>

#include "integrators/partitioned.hpp"

namespace atwood {

//   x_half = x + h/2 v
//   v_new  = v + h a(t + h/2, x_half)
//   x_new  = x_half + h/2 v_new
template <class S> bool Leapfrog<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + this->system_.size, y_new);
  drift(model_, h_s / S(2), FreeTop::strang, y_new);
  const bool solved = kicker_.symmetric_kick(t_s + h_s / S(2), h_s, y_new);
  drift(model_, h_s / S(2), FreeTop::strang, y_new);
  this->system_.project(y_new);
  this->remember(t_s, h_s, y, y_new);
  return solved;
}

template class Leapfrog<float>;
template class Leapfrog<double>;
template class Leapfrog<long double>;
template class Leapfrog<Quad>;

}  // namespace atwood
