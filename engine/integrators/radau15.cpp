#include "integrators/radau15.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include "math/elementary.hpp"

#include "integrators/radau15_kernels.hpp"
#include "integrators/radau15_point_masses.hpp"
#include "integrators/radau15_timescale.hpp"

namespace atwood {
namespace {

constexpr int kNodes = kRadauNodes;

template <class S> S dot(const S* f, const S* w) {
  return ((f[0] * w[0] + f[1] * w[1]) + (f[2] * w[2] + f[3] * w[3])) +
         ((f[4] * w[4] + f[5] * w[5]) + (f[6] * w[6] + f[7] * w[7]));
}

}  // namespace

template <class S>
Radau15<S>::Radau15(System<S>& system, const RigidModel<S>* model, const RadauOptions& options)
    : Stepper<S>(system), model_(model), options_(options), table_(radau_table<S>()), size_(system.size),
      compensation_(size_), compensation_new_(size_), weight_(size_), state_(size_), base_(size_), rate_(size_),
      rate_before_(size_), predicted_(size_), ends_(size_), node_state_(2 * size_), node_rate_(size_) {
  for (auto* list : {&once_, &twice_[0].components, &twice_[1].components, &rates_}) list->reserve(size_);
  kinds_.reserve(6);
  scale_.reserve(6);
  for (Record& record : record_) {
    record.y.resize(size_);
    record.y_new.resize(size_);
    record.compensation.resize(size_);
    record.compensation_new.resize(size_);
    record.rate.resize(size_);
    record.prediction_error.resize(size_);
  }
  if constexpr (std::is_same_v<S, double>)
    if (options.fused && !options.sequential && model != nullptr) bodies_ = gravitating_bodies(*model);
}

template <class S> Radau15<S>::~Radau15() = default;

// Velocities need no stages where no force depends on them; attitudes and body rates always do.
template <class S> void Radau15<S>::find_unknowns() {
  epoch_ = this->system_.epoch;
  once_.clear();
  for (Twice& twice : twice_) twice.components.clear();
  rates_.clear();
  kinds_.clear();
  record_[0].valid = record_[1].valid = false;
  kept_ = -1;
  const auto add_kind = [&](int from, int to) {
    const int first = static_cast<int>(rates_.size());
    for (const int body : model_->moving()) {
      if (from >= kAtAttitude && !model_->rotates(body)) continue;
      for (int i = from; i < to; ++i) rates_.push_back(model_->offset(body) + i);
    }
    if (static_cast<int>(rates_.size()) > first) kinds_.push_back({first, static_cast<int>(rates_.size())});
  };
  if (model_ == nullptr || model_->bare_problem()) {
    for (int i = 0; i < size_; ++i) rates_.push_back(i);
    once_ = rates_;
    kinds_.push_back({0, size_});
  } else {
    add_kind(kAtVelocity, kAtAttitude);
    twice_[0].shift = kAtVelocity - kAtPosition;
    for (const int i : rates_) twice_[0].components.push_back(i - twice_[0].shift);
    if (model_->velocity_dependent()) once_ = rates_;
    const std::size_t turning = rates_.size();
    add_kind(kAtAttitude, kAtBodyRate);
    add_kind(kAtBodyRate, kAtBodyRate + 3);
    if (model_->tree() != nullptr) add_joints(*model_->tree());
    once_.insert(once_.end(), rates_.begin() + turning, rates_.end());
  }
  scale_.resize(kinds_.size());
  std::fill(lanes_of(state_), lanes_of(state_) + size_ * kNodes, S(0));
}

// The rates of joints are integrated once, their coordinates twice; a ball's quaternion like a body's.
template <class S> void Radau15<S>::add_joints(const Tree<S>& tree) {
  const auto end_kind = [&](int first) {
    const int last = static_cast<int>(rates_.size());
    if (last > first) kinds_.push_back({first, last});
    return last;
  };
  twice_[1].shift = tree.scalar_count();
  int first = static_cast<int>(rates_.size());
  for (int i = 0; i < tree.scalar_count(); ++i) {
    twice_[1].components.push_back(tree.scalars_at() + i);
    rates_.push_back(tree.scalars_at() + tree.scalar_count() + i);
  }
  first = end_kind(first);
  for (const bool rate : {false, true}) {
    for (const Link<S>& link : tree.links())
      if (link.joint >= 0 && link.kind == JointKind::ball)
        for (int k = 0; k < (rate ? 3 : 4); ++k) rates_.push_back((rate ? link.at_u : link.at_q) + k);
    first = end_kind(first);
  }
}

// The stored step that the new one continues or repeats; `offset` is the new start in units of that step: 1, or 0 for a
// repeated step.
template <class S> auto Radau15<S>::find_start(S t_s, const S* y, S& offset) -> Record* {
  for (const int r : {last_, 1 - last_}) {
    Record& record = record_[r];
    if (!record.valid) continue;
    const S near_s = S(8) * real::epsilon<S>() * (real::abs(record.t_s) + real::abs(record.h_s));
    if (real::abs(t_s - (record.t_s + record.h_s)) <= near_s && std::equal(y, y + size_, record.y_new.begin())) {
      offset = S(1);
      return &record;
    }
  }
  for (const int r : {last_, 1 - last_}) {
    Record& record = record_[r];
    if (!record.valid || record.t_s != t_s || !std::equal(y, y + size_, record.y.begin())) continue;
    offset = S(0);
    return &record;
  }
  return nullptr;
}

template <class S> void Radau15<S>::predict(S h_s, Record* from, S offset) {
  S* out = lanes_of(predicted_);
  if (from == nullptr) {
    std::fill(out, out + size_ * kNodes, S(0));
    return;
  }
  const S ratio = h_s / from->h_s;
  alignas(LaneBlock<S>) S weight[kNodes] = {};
  if (offset == S(1)) radau::weigh_last_error(table_, ratio, from->extrapolation, extrapolation_, weight);
  in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
    using P = PackAt<S, decltype(width)::value>;
    radau::extrapolate<P>(rates_, table_, offset, ratio, weight, lanes_of(from->rate), lanes_of(from->prediction_error),
                          out);
  });
}

template <class S> void Radau15<S>::set_base(S t_s, S h_s, const S* y) {
  S* base = lanes_of(base_);
  for (int k = 0; k < kNodes; ++k) t_nodes_[k] = t_s + table_.c[k] * h_s;
  in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
    using P = PackAt<S, decltype(width)::value>;
    radau::set_base<P>(once_, y, base);
    for (const Twice& twice : twice_) radau::set_base<P>(twice.components, twice.shift, table_, h_s, y, base);
  });
  for (std::size_t n = 0; n < kinds_.size(); ++n) {
    scale_[n].state = S(0);
    for (int r = kinds_[n].first; r < kinds_[n].last; ++r)
      scale_[n].state = real::max(scale_[n].state, real::abs(y[rates_[r]]));
  }
}

// weight = h / (size of the state + its change in the step).
template <class S> void Radau15<S>::measure_scales(const S* rate) {
  const S h_s = real::abs(this->h_s_);
  for (std::size_t n = 0; n < kinds_.size(); ++n) {
    in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
      using P = PackAt<S, decltype(width)::value>;
      scale_[n].rate = radau::largest<P>(rates_, kinds_[n].first, kinds_[n].last, rate);
    });
    const S whole = scale_[n].state + h_s * scale_[n].rate + (rtol_ > S(0) ? atol_ / rtol_ : S(0));
    const S weight = whole > S(0) ? h_s / whole : S(0);
    for (int r = kinds_[n].first; r < kinds_[n].last; ++r) weight_[r] = weight;
  }
}

// Evaluates the rates of all nodes at states that use the rates of the last sweep (Jacobi iteration).
template <class S> S Radau15<S>::sweep_batch(S h_s, LaneArray<S>& rate_before) {
  S *state = lanes_of(state_), *rate = lanes_of(rate_);
  const S* before = lanes_of(rate_before);
  in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
    using P = PackAt<S, decltype(width)::value>;
    for (const Twice& twice : twice_)
      radau::stages<P>(twice.components, twice.shift, table_.a2, h_s * h_s, lanes_of(base_), before, state);
    radau::stages<P>(once_, 0, table_.a, h_s, lanes_of(base_), before, state);
  });
  this->system_.rates(kNodes, t_nodes_, state, rate, node_state_.data());
  S most{};
  in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
    using P = PackAt<S, decltype(width)::value>;
    most = radau::change<P>(rates_, weight_.data(), rate, before);
  });
  return most;
}

// Node by node; the new rate of a node corrects those of the later nodes at once (Rein and Spiegel, eq. 10).
template <class S> S Radau15<S>::sweep_nodes(S h_s) {
  S *rate = lanes_of(rate_), *base = lanes_of(base_);
  S most = S(0);
  for (int n = 1; n < kNodes; ++n) {
    for (const Twice& twice : twice_)
      for (const int i : twice.components)
        node_state_[i] = base[i * kNodes + n] + h_s * h_s * dot(rate + (i + twice.shift) * kNodes, table_.row2[n]);
    for (const int i : once_) node_state_[i] = base[i * kNodes + n] + h_s * dot(rate + i * kNodes, table_.row[n]);
    this->system_.rate(t_nodes_[n], node_state_.data(), node_rate_.data());
    S now{};
    in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
      using P = PackAt<S, decltype(width)::value>;
      now = radau::shift_later_nodes<P>(rates_, weight_.data(), table_, n, node_rate_.data(), rate);
    });
    most = now <= most ? most : now;
  }
  return most;
}

// Whether the sweeps ended with the rates at the nodes.
template <class S> bool Radau15<S>::iterate(S h_s, bool predicted) {
  radau::SweepEnd<S> end(rtol_, options_.sequential, contraction_);
  for (bool first = true;; first = false) {
    S now;
    if (options_.sequential) {
      now = sweep_nodes(h_s);
    } else {
      if (!first) rate_.swap(rate_before_);
      now = sweep_batch(h_s, first ? predicted_ : rate_before_);
    }
    const bool blind = first && !predicted;
    if (end.reached(now, blind)) break;
    if (blind) measure_scales(lanes_of(rate_));  // the scales need rates, which exist from here on
  }
  contraction_ = end.contraction;
  return this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, end.report());
}

template <class S> void Radau15<S>::finish(S h_s, const S* y, S* y_new) {
  S* ends = lanes_of(ends_);
  in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
    using P = PackAt<S, decltype(width)::value>;
    radau::sum_ends<P>(rates_, table_, lanes_of(rate_), ends);
  });
  std::copy(y, y + size_, y_new);
  for (const auto& [components, shift] : twice_)
    for (const int i : components) y_new[i] = add(i, y[i], h_s * (y[i + shift] + h_s * ends[(i + shift) * kNodes + 1]));
  for (const int i : rates_) y_new[i] = add(i, y[i], h_s * ends[i * kNodes]);
  this->system_.project(y_new);
}

// Kahan's sum with Knuth's two-sum, as in compensation.hpp; the remainders are stored with the step, so that samples
// inside it and repeated steps start from the same remainders.
template <class S> S Radau15<S>::add(int i, S y, S increment) {
  if (!options_.compensated) return y + increment;
  const S wanted = increment + compensation_[i], sum = y + wanted, part = sum - y;
  compensation_new_[i] = (y - (sum - part)) + (wanted - part);
  return sum;
}

// Keeps the record of the last step that advise() accepted: samples inside it are steps from its start, and the next
// step starts at its end.
template <class S> auto Radau15<S>::next_record() -> Record& { return record_[kept_ >= 0 ? 1 - kept_ : 1 - last_]; }

template <class S> void Radau15<S>::store_record(S t_s, S h_s, const S* y, const S* y_new) {
  Record& record = next_record();
  last_ = static_cast<int>(&record - record_);
  record.valid = true;
  record.t_s = t_s;
  record.h_s = h_s;
  record.contraction = contraction_;
  std::copy(y, y + size_, record.y.begin());
  std::copy(y_new, y_new + size_, record.y_new.begin());
}

template <class S> bool Radau15<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  if (epoch_ != this->system_.epoch) find_unknowns();
  this->set_last_step(t_s, h_s, y, y_new);
  S offset = S(0);
  Record* from = find_start(t_s, y, offset);
  contraction_ = from != nullptr ? from->contraction : S(1);
  converged_ = bodies_ ? step_fused(h_s, y, y_new, from, offset) : step_general(t_s, h_s, y, y_new, from, offset);
  if (!converged_) {
    std::copy(y, y + size_, y_new);
    return rtol_ > S(0);  // advise() then asks for a shorter step
  }
  store_record(t_s, h_s, y, y_new);
  return true;
}

template <class S> bool Radau15<S>::step_general(S t_s, S h_s, const S* y, S* y_new, Record* from, S offset) {
  if (from == nullptr) std::fill(compensation_.begin(), compensation_.end(), S(0));
  else compensation_ = offset == S(1) ? from->compensation_new : from->compensation;
  extrapolation_ = {};
  predict(h_s, from, offset);
  set_base(t_s, h_s, y);
  if (options_.sequential) start_nodes(t_s, y, from != nullptr);
  measure_scales(lanes_of(options_.sequential ? rate_ : predicted_));
  if (!iterate(h_s, from != nullptr)) return false;
  finish(h_s, y, y_new);
  Record& record = next_record();
  record.compensation.swap(compensation_);
  record.compensation_new.swap(compensation_new_);
  S* prediction_error = lanes_of(record.prediction_error);
  if (offset == S(1))
    in_lanes<S>(width_, [&](auto width) ATWOOD_INLINED {
      using P = PackAt<S, decltype(width)::value>;
      radau::differences<P>(rates_, lanes_of(rate_), lanes_of(predicted_), prediction_error);
    });
  else std::fill(prediction_error, prediction_error + size_ * kNodes, S(0));
  record.rate.swap(rate_);
  record.extrapolation = extrapolation_;
  return true;
}

template <class S> bool Radau15<S>::step_fused(S h_s, const S* y, S* y_new, Record* from, S offset) {
  if constexpr (std::is_same_v<S, double>) {
    Record& record = next_record();
    record.in_plane = from != nullptr ? from->in_plane : bodies_->in_plane(y);
    if (from == nullptr) std::fill(record.compensation.begin(), record.compensation.end(), 0.0);
    else if (offset == 1) record.compensation = from->compensation_new;
    else if (from != &record) record.compensation = from->compensation;
    const bool known = from != nullptr;
    GravitatingStep step{.h_s = h_s,
                         .rtol = rtol_,
                         .atol_over_rtol = rtol_ > 0 ? atol_ / rtol_ : 0,
                         .in_plane = record.in_plane,
                         .compensated = options_.compensated,
                         .y = y,
                         .compensation = record.compensation.data(),
                         .rate_from = known ? lanes_of(from->rate) : nullptr,
                         .error_from = known ? lanes_of(from->prediction_error) : nullptr,
                         .extrapolation_from = known ? &from->extrapolation : nullptr,
                         .offset = offset,
                         .ratio = known ? h_s / from->h_s : 1,
                         .y_new = y_new,
                         .compensation_new = record.compensation_new.data(),
                         .rate = lanes_of(record.rate),
                         .prediction_error = lanes_of(record.prediction_error),
                         .extrapolation = &record.extrapolation,
                         .contraction = contraction_};
    step_gravitating_bodies(width_, *bodies_, step);
    this->system_.evaluations += kNodes * step.report.iterations;
    if (!this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, step.report)) {
      record.valid = false;  // it has lost its remainders
      return false;
    }
    if (!known || offset != 1) record.extrapolation = {};
    contraction_ = step.contraction;
    roughness_ = step.rate_size > 0 ? step.last_coefficient / step.rate_size : 0;
    return true;
  }
  return false;
}

// The rate at the start of the step is evaluated once; without a prediction it is the first guess at every node.
template <class S> void Radau15<S>::start_nodes(S t_s, const S* y, bool predicted) {
  S* rate = lanes_of(rate_);
  if (predicted) std::copy(lanes_of(predicted_), lanes_of(predicted_) + size_ * kNodes, rate);
  this->system_.rate(t_s, y, node_rate_.data());
  for (const int i : rates_) {
    S* f = rate + i * kNodes;
    std::fill(f, predicted ? f + 1 : f + kNodes, node_rate_[i]);
  }
}

template <class S> void Radau15<S>::set_tolerance(S rtol, S atol) {
  rtol_ = rtol;
  atol_ = atol;
  record_[0].valid = record_[1].valid = false;
  kept_ = -1;
}

// Ratio of the last coefficient of the rates' polynomial to the rates.
template <class S> S Radau15<S>::roughness() const {
  if (bodies_) return roughness_;
  S most = S(0);
  for (std::size_t n = 0; n < kinds_.size(); ++n) {
    S top = S(0);
    for (int r = kinds_[n].first; r < kinds_[n].last; ++r) top = real::max(top, real::abs(ends_[rates_[r]].lane[2]));
    if (scale_[n].rate > S(0)) most = real::max(most, top / scale_[n].rate);
  }
  return most;
}

// The least timescale (radau15_timescale.hpp) of any body, and of each kind of the other unknowns as a whole; 0:
// nothing changes.
template <class S> S Radau15<S>::least_timescale() const {
  S least{};
  for (std::size_t n = 0; n < kinds_.size(); ++n) {
    const auto [first, last] = kinds_[n];
    const bool by_body = n == 0 && !twice_[0].components.empty();
    for (int from = first; from < last; from += by_body ? 3 : last - first) {
      const int count = by_body ? 3 : last - first;
      const S timescale = radau_timescale(table_, &rates_[from], count, record_[last_].rate);
      if (timescale > S(0) && (least == S(0) || timescale < least)) least = timescale;
    }
  }
  return least;
}

// The next step over this one: (epsilon / b6)^(1/7) with b6 the last coefficient over the rates (Rein, Spiegel 2015,
// eq. 11), or tau (5040 epsilon)^(1/7) (Pham, Rein, Spiegel 2024). Infinity: nothing changes.
template <class S> double Radau15<S>::published_factor() const {
  const double none = std::numeric_limits<double>::infinity();
  if (options_.criterion == StepCriterion::prs23) {
    const double timescale = static_cast<double>(least_timescale());
    return timescale > 0 ? timescale * real::step_power(5040 * options_.epsilon, 1.0 / 7) : none;
  }
  const double b6 = static_cast<double>(roughness());
  return b6 > 0 ? real::step_power(options_.epsilon / b6, 1.0 / 7) : none;
}

// The rates' coefficients fall about as q^k h^k, so the last one, over the rates, is q^7; the local error of order 16
// is a constant times q^15, estimated as q^14 / 100: errors on Kepler and Pleiades are then near the tolerance.
template <class S> auto Radau15<S>::advise(S rtol, S) -> typename Stepper<S>::Advice {
  const S h_s = this->h_s_;
  if (!converged_) return {false, h_s / S(2)};
  if (options_.criterion !=
      StepCriterion::tolerance) {  // a step is repeated below a quarter, and grows at most fourfold
    const double factor = published_factor();
    if (factor < 0.25) return {false, h_s * S(real::max(factor, 0.01))};
    kept_ = last_;
    return {true, h_s * S(real::min(factor, 4.0))};
  }
  const float rough = static_cast<float>(roughness()), wanted = static_cast<float>(S(100) * rtol);
  const float factor = rough > 0 ? static_cast<float>(real::step_power(wanted / (rough * rough), 1.0 / 14)) : 2.0f;
  if (factor < 0.75) return {false, h_s * S(real::max(factor, 0.1f))};
  const float most = kept_ < 0 ? 16.0f : 2.0f;  // the first step was a guess
  kept_ = last_;
  return {true, h_s * S(real::min(factor, most))};
}

// Evaluates the polynomial of the step; of order 9 between the nodes.
template <class S> void Radau15<S>::dense(S theta, S* y_at) {
  const S h_s = this->h_s_;
  S* rate = lanes_of(record_[last_].rate);
  std::copy(this->y_, this->y_ + size_, y_at);
  S once[kNodes], twice[kNodes], power = theta;
  for (int k = 0; k < kNodes; ++k) {
    once[k] = power / S(k + 1);
    power *= theta;
    twice[k] = power / S((k + 1) * (k + 2));
  }
  const auto integral = [&](int i, const S* weight) {
    S sum = S(0);
    for (int j = 0; j < kNodes; ++j) sum += rate[i * kNodes + j] * dot(weight, table_.power[j]);
    return sum;
  };
  for (const auto& [components, shift] : twice_)
    for (const int i : components) y_at[i] += h_s * (theta * this->y_[i + shift] + h_s * integral(i + shift, twice));
  for (const int i : rates_) y_at[i] += h_s * integral(i, once);
  this->system_.project(y_at);
}

template class Radau15<float>;
template class Radau15<double>;
template class Radau15<long double>;
template class Radau15<Quad>;

}  // namespace atwood
