#include "integrators/free_flight.hpp"

#include <algorithm>

#include "integrators/free_flight_alone.hpp"

namespace atwood {
namespace {

constexpr std::int64_t kMinShared = 4000;  // bodies times steps: some 15 us
constexpr std::size_t kMaxBodiesAlone = 3;
constexpr FlightKind kKinds[] = {FlightKind::about_body_axes, FlightKind::about_any_axes, FlightKind::point_mass};

template <class S> FlightKind kind_of(const RigidModel<S>& model, int body) {
  if (!model.rotates(body)) return FlightKind::point_mass;
  return model.mass(body).diagonal ? FlightKind::about_body_axes : FlightKind::about_any_axes;
}

template <int rows, class S> void copy_in(const S* from, S (&to)[rows][kFlightLanes], int l) {
  for (int r = 0; r < rows; ++r) to[r][l] = from[r];
}
template <int rows, class S> void copy_out(const S (&from)[rows][kFlightLanes], int l, S* to) {
  for (int r = 0; r < rows; ++r) to[r] = from[r][l];
}

template <class S, int lanes>
void put_inertia(FlightKind kind, const MassProperties<S>& mass, FlightInertia<S, lanes>& inertia, int l) {
  const auto put = [&](int entry, S I, S I_inverse) {
    inertia.I[entry][l] = I;
    inertia.twice_I_inverse[entry][l] = S(2) * I_inverse;
  };
  if (kind == FlightKind::point_mass) return;
  if (kind == FlightKind::about_body_axes) {
    put(0, mass.I_row[0].x, mass.I_inverse_row[0].x);
    put(4, mass.I_row[1].y, mass.I_inverse_row[1].y);
    put(8, mass.I_row[2].z, mass.I_inverse_row[2].z);
    return;
  }
  for (int r = 0; r < 3; ++r) {
    put(3 * r, mass.I_row[r].x, mass.I_inverse_row[r].x);
    put(3 * r + 1, mass.I_row[r].y, mass.I_inverse_row[r].y);
    put(3 * r + 2, mass.I_row[r].z, mass.I_inverse_row[r].z);
  }
}

}  // namespace

template <class S>
FreeFlight<S>::FreeFlight(RigidModel<S>& model, ExplicitWeights<S> weights)
    : model_(model), weights_(std::move(weights)), steps_(weights_),
      lanes_(model.team() == nullptr ? 1 : model.team()->size()) {
  for (FlightLanes<S>& lanes : lanes_) lanes.rates.resize(weights_.a.size() * 7 * kFlightLanes);
  sorted_.reserve(model.body_count());
  for (int i = 0; i < model.body_count(); ++i) fixed_ += model.offset(i) < 0;
  steps_.set_gravity(model.uniform_gravity() + Vec3<S>{});
  inertia_.resize(model.body_count());
  for (int i = 0; i < model.body_count(); ++i) put_inertia(kind_of(model, i), model.mass(i), inertia_[i], 0);
}

// Sorts the moving bodies by kind. Held bodies are not among them; which bodies are held changes with the model's
// epoch.
template <class S> void FreeFlight<S>::sort_bodies() {
  if (epoch_ == model_.system().epoch) return;
  epoch_ = model_.system().epoch;
  sorted_.clear();
  for (const FlightKind kind : kKinds) {
    for (const int i : model_.moving())
      if (kind_of(model_, i) == kind) sorted_.push_back(i);
    end_[static_cast<int>(kind)] = static_cast<int>(sorted_.size());
  }
}

template <class S> void FreeFlight<S>::gather(FlightKind kind, const S* y, Share bodies, FlightLanes<S>& lanes) const {
  for (int n = bodies.first; n < bodies.last; ++n) {
    const int l = n - bodies.first, i = sorted_[n];
    const S* at = y + model_.offset(i);
    copy_in(at + kAtPosition, lanes.p, l);
    copy_in(at + kAtVelocity, lanes.v, l);
    if (kind == FlightKind::point_mass) continue;
    copy_in(at + kAtAttitude, lanes.q, l);
    const MassProperties<S>& mass = model_.mass(i);
    for (int r = 0; r < 3; ++r) {
      lanes.half_w[r][l] = S(0.5) * at[kAtBodyRate + r];
    }
    put_inertia(kind, mass, lanes.inertia, l);
  }
}

template <class S> void FreeFlight<S>::scatter(FlightKind kind, S* y, Share bodies, const FlightLanes<S>& lanes) const {
  for (int n = bodies.first; n < bodies.last; ++n) {
    const int l = n - bodies.first;
    S* at = y + model_.offset(sorted_[n]);
    copy_out(lanes.p, l, at + kAtPosition);
    copy_out(lanes.v, l, at + kAtVelocity);
    if (kind == FlightKind::point_mass) continue;
    copy_out(lanes.q, l, at + kAtAttitude);
    for (int r = 0; r < 3; ++r) at[kAtBodyRate + r] = S(2) * lanes.half_w[r][l];
  }
}

template <class S>
void FreeFlight<S>::march_group(FlightKind kind, std::int64_t count, S* y, Share bodies, FlightLanes<S>& lanes) const {
  if constexpr (std::is_same_v<S, double>) {
    if (bodies.last - bodies.first <= static_cast<int>(kMaxBodiesAlone) && flies_alone(width_, kind, steps_)) {
      for (int n = bodies.first; n < bodies.last; ++n)
        fly_many_alone(width_, steps_, inertia_[sorted_[n]], count, y + model_.offset(sorted_[n]));
      return;
    }
  }
  for (int first = bodies.first; first < bodies.last; first += kFlightLanes) {
    const Share block{first, std::min(first + kFlightLanes, bodies.last)};
    gather(kind, y, block, lanes);
    fly(width_, kind, block.last - block.first, steps_, count, lanes);
    scatter(kind, y, block, lanes);
  }
}

// A held body's slopes are zero; as in the general stepper, adding h * 0 changes -0 to 0.
template <class S> void hold_still(const RigidModel<S>& model, S* y) {
  if (static_cast<int>(model.moving().size()) == model.body_count()) return;
  auto moving = model.moving().begin();
  for (int i = 0; i < model.body_count(); ++i) {
    if (moving != model.moving().end() && *moving == i) {
      ++moving;
    } else if (model.offset(i) >= 0) {
      S* at = y + model.offset(i);
      for (int k = 0; k < (model.rotates(i) ? 13 : 6); ++k) at[k] = at[k] + S(0);
    }
  }
}

template <class S> void FreeFlight<S>::march(S h_s, std::int64_t count, S* y) {
  if (count <= 0) return;
  sort_bodies();
  steps_.set_step(h_s);
  const auto part = [&](int p, int parts) {
    for (const FlightKind kind : kKinds) {
      const int k = static_cast<int>(kind), begin = k == 0 ? 0 : end_[k - 1];
      const Share bodies = share(end_[k] - begin, p, parts);
      march_group(kind, count, y, {begin + bodies.first, begin + bodies.last}, lanes_[p]);
    }
  };
  if (model_.team() == nullptr) part(0, 1);
  else
    model_.team()->run(count * static_cast<std::int64_t>(sorted_.size()) >= kMinShared,
                       [&](int p) { part(p, model_.team()->size()); });
  hold_still(model_, y);
  count_evaluations(count);
}

template <class S> void FreeFlight<S>::count_evaluations(std::int64_t steps) {
  System<S>& system = model_.system();
  system.evaluations += steps * (weights_.first_same_as_last ? weights_.stages() - 1 : weights_.stages());
  if (weights_.first_same_as_last && counted_epoch_ != system.epoch)
    ++system.evaluations;  // the first step's first stage
  counted_epoch_ = system.epoch;
}

// For a few bodies lanes are slower than a loop over single bodies.
template <class S> void FreeFlight<S>::step(S h_s, const S* y, S* y_new) {
  const auto bodies = model_.moving();
  const bool some_are_held = static_cast<int>(bodies.size()) < model_.body_count() - fixed_;
  if (bodies.size() > kMaxBodiesAlone || some_are_held || weights_.stages() > kMaxStagesAlone) {
    std::copy_n(y, model_.state_size(), y_new);
    return march(h_s, 1, y_new);
  }
  steps_.set_step(h_s);
  for (const int i : bodies)
    fly_alone(kind_of(model_, i), steps_, inertia_[i], y + model_.offset(i), y_new + model_.offset(i));
  count_evaluations(1);
}

template <class S>
std::unique_ptr<FreeFlight<S>> make_free_flight(RigidModel<S>& model, const ExplicitWeights<S>* weights) {
  if constexpr (has_vector_lanes<S>) {
    if (weights == nullptr || model.bare_problem() || model.tree() != nullptr || model.feels_forces()) return nullptr;
    return std::make_unique<FreeFlight<S>>(model, *weights);
  } else {
    return nullptr;
  }
}

template class FreeFlight<float>;
template class FreeFlight<double>;
template std::unique_ptr<FreeFlight<float>> make_free_flight(RigidModel<float>&, const ExplicitWeights<float>*);
template std::unique_ptr<FreeFlight<double>> make_free_flight(RigidModel<double>&, const ExplicitWeights<double>*);
template std::unique_ptr<FreeFlight<long double>> make_free_flight(RigidModel<long double>&,
                                                                   const ExplicitWeights<long double>*);
template std::unique_ptr<FreeFlight<Quad>> make_free_flight(RigidModel<Quad>&, const ExplicitWeights<Quad>*);

}  // namespace atwood
