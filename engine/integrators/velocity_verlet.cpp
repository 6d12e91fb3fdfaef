#include <algorithm>

#include "integrators/partitioned.hpp"

namespace atwood {

//   v_half = v + h/2 a(t, x)
//   x_new  = x + h v_half
//   v_new  = v_half + h/2 a(t + h, x_new)
template <class S> bool VelocityVerlet<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + this->system_.size, y_new);
  const bool first = kicker_.symmetric_kick(t_s, h_s / S(2), y_new);
  drift(model_, h_s, FreeTop::strang, y_new);
  const bool second = kicker_.symmetric_kick(t_s + h_s, h_s / S(2), y_new);
  this->system_.project(y_new);
  this->remember(t_s, h_s, y, y_new);
  return first && second;
}

template class VelocityVerlet<float>;
template class VelocityVerlet<double>;
template class VelocityVerlet<long double>;
template class VelocityVerlet<Quad>;

}  // namespace atwood
