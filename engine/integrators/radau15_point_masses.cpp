#include "integrators/radau15_point_masses.hpp"

#include <algorithm>

#include "integrators/radau15_kernels.hpp"

namespace atwood {
namespace {

using radau::Columns;
using radau::kNodes;
constexpr int kBodySize = 6;  // p and v
constexpr int kCorrections = 2;
// Corrections stop where what they leave is this part of what the sweeps may leave: they cost less than a sweep.
constexpr double kCorrected = 1e-3;

// x^(-1/2) to 3.5 %, from the bits of x (Lomont 2003).
template <class V> ATWOOD_INLINE V guess_inverse_root(const V& x) {
  return bits_as<V>(0x5fe6eb50c7b537a9 - (bits_as<typename Integers<V>::Unsigned>(x) >> 1));
}
template <class V> ATWOOD_INLINE Halves<V> guess_inverse_root(const Halves<V>& x) {
  return {guess_inverse_root(x.low), guess_inverse_root(x.high)};
}

// x^(-3/2) to 3 units in the last place, and x^-1 to 1e-5: some 25 additions and multiplications, which run in the
// pipelines of a processor where square roots and divisions of packs wait for one unit. Of a first guess y of x^(-1/2),
// with e = 1 - x y^2, the series of (1 - e)^(-1/2) and, for the result, of (1 - e)^(-3/2). 0 and infinity give no
// finite number.
template <class P> ATWOOD_INLINE P inverse_cube_of_root(const P& x, P& inverse) {
  P y = guess_inverse_root(x);
  P e = 1.0 - x * (y * y);
  y = y + y * (e * (0.5 + e * (0.375 + e * 0.3125)));
  inverse = y * y;
  e = 1.0 - x * inverse;
  const P cube = y * inverse;
  return cube + cube * (e * (1.5 + e * (1.875 + e * 2.1875)));
}
constexpr std::size_t kMaxCentres = kMaxGravitating, kMaxPairs = kMaxGravitating * (kMaxGravitating - 1) / 2;

// `known` bodies, 1: one about one centre; 0: as many as there are. In two dimensions z is a constant.
template <VectorWidth width, int known, int dimensions> class Kernel {
 public:
  ATWOOD_INLINE Kernel(const GravitatingBodies& system, GravitatingStep& step)
      : system_(system), step_(step), bodies_(known > 0 ? known : system.count) {}

  ATWOOD_INLINE void run() {
    predict();
    set_base();
    sweep();
    if (step_.report.ended == SolveEnd::capped) return;
    finish();
    if constexpr (dimensions == 2) keep_plane();
  }

 private:
  using P = PackAt<double, width>;
  static constexpr int kRoom = dimensions * (known > 0 ? known : kMaxGravitating);
  using Rows = double[kRoom][kNodes];

  // f(row, the component of the position); its velocity and the rate of that stand three further on.
  template <class F> ATWOOD_INLINE void for_rows(const F& f) const {
    for (int b = 0; b < bodies_; ++b)
      for (int c = 0; c < dimensions; ++c) f(b * dimensions + c, b * kBodySize + c);
  }

  ATWOOD_INLINE void predict() {
    if (step_.rate_from == nullptr) return for_rows([&](int r, int) ATWOOD_INLINED { store<double>(P{}, rate_[r]); });
    const P tau = step_.offset + step_.ratio * load_as<P>(table_.c);
    alignas(P) double weight[kNodes] = {};
    if (step_.offset == 1)
      radau::weigh_last_error(table_, step_.ratio, *step_.extrapolation_from, *step_.extrapolation, weight);
    const Columns<P> powers(table_.power, 1.0);
    for_rows([&](int r, int i) ATWOOD_INLINED {
      const std::ptrdiff_t at = (i + 3) * kNodes;
      store<double>(radau::polynomial<P>(powers, tau, step_.rate_from + at) +
                        load_as<P>(weight) * load_as<P>(step_.error_from + at),
                    rate_[r]);
    });
    for_rows([&](int r, int) ATWOOD_INLINED { store<double>(load_as<P>(rate_[r]), predicted_[r]); });
  }

  ATWOOD_INLINE void set_base() {
    const P elapsed_s = step_.h_s * load_as<P>(table_.c);
    for_rows([&](int r, int i) ATWOOD_INLINED { base_[r] = step_.y[i] + step_.y[i + 3] * elapsed_s; });
    for_rows([&](int r, int i)
                 ATWOOD_INLINED { field_[r] = P{} + system_.field_m_per_s2[i / kBodySize][i % kBodySize]; });
    speed_ = 0;
    for (int b = 0; b < bodies_; ++b)
      for (int c = 3; c < 6; ++c) speed_ = real::max(speed_, real::abs(step_.y[b * kBodySize + c]));
  }

  ATWOOD_INLINE double largest_rate(const Rows& rate) const {
    radau::LargestSize<P> most;
    for_rows([&](int r, int) ATWOOD_INLINED { most.add(load_as<P>(rate[r])); });
    return most.value();
  }

  // h / (size of the velocities + their change in the step)
  ATWOOD_INLINE double weight_of(const Rows& rate) {
    const double h_s = real::abs(step_.h_s);
    step_.rate_size = largest_rate(rate);
    const double whole = speed_ + h_s * step_.rate_size + step_.atol_over_rtol;
    return whole > 0 ? h_s / whole : 0;
  }

  // r and the factors of an attraction at the states of the last sweep: a = f r / R^3 of the weight f, R^2 = r^2 + s^2,
  // whose derivative along w is f (w - 3 r (r w) / R^2) / R^3.
  struct Attraction {
    P r[dimensions], inverse_cube, three_by_square;  // of a centre `inverse_cube` contains its weight

    ATWOOD_INLINE void derive(const P* w, P* out) const {
      P along = r[0] * w[0] + r[1] * w[1];
      if constexpr (dimensions == 3) along = along + r[2] * w[2];
      along = three_by_square * along;
      for (int c = 0; c < dimensions; ++c) out[c] = inverse_cube * (w[c] - along * r[c]);
    }
  };
  ATWOOD_INLINE static P square(const P* r) {
    P r2 = r[0] * r[0] + r[1] * r[1];
    if constexpr (dimensions == 3) r2 = r2 + r[2] * r[2];
    return r2;
  }

  // Where the body of a centre stands in the rows.
  static int of_centre(const GravitatingBodies::Centre& centre) { return (known == 1 ? 0 : centre.body) * dimensions; }

  template <class F> ATWOOD_INLINE void for_centres(const F& f) const {
    if constexpr (known == 1) f(system_.centres[0]);
    else
      for (const GravitatingBodies::Centre& centre : system_.centres) f(centre);
  }

  ATWOOD_INLINE void accelerate(const P* x, P* a) {
    for_rows([&](int r, int) ATWOOD_INLINED { a[r] = field_[r]; });
    Attraction* attraction = attractions_;
    for_centres([&](const GravitatingBodies::Centre& centre) ATWOOD_INLINED {
      const int at = of_centre(centre);
      Attraction& now = *attraction++;
      for (int c = 0; c < dimensions; ++c) now.r[c] = x[at + c] - centre.at_m[c];
      const P square_m2 = square(now.r) + centre.softening2_m2, distance_m = root(WholePack<width>{}, square_m2);
      now.inverse_cube = centre.mu_m3_per_s2 / (square_m2 * distance_m);
      now.three_by_square = centre.three_by_mu * distance_m * now.inverse_cube;
      for (int c = 0; c < dimensions; ++c) a[at + c] = a[at + c] - now.inverse_cube * now.r[c];
    });
    if constexpr (known == 1) return;
    // Two pairs at once: one alone is a chain of operations that wait for each other.
    const GravitatingBodies::Pair* pair = system_.pairs.data();
    const GravitatingBodies::Pair* const end = pair + system_.pairs.size();
    for (; end - pair >= 2; pair += 2, attraction += 2) {
      const P between[2] = {separate(pair[0], x, attraction[0]), separate(pair[1], x, attraction[1])};
      Halves<P> inverse_square;
      const Halves<P> inverse_cube = inverse_cube_of_root(Halves<P>(between[0], between[1]), inverse_square);
      attract(pair[0], inverse_cube.low, inverse_square.low, attraction[0], a);
      attract(pair[1], inverse_cube.high, inverse_square.high, attraction[1], a);
    }
    if (pair != end) {
      P inverse_square;
      const P inverse_cube = inverse_cube_of_root(separate(*pair, x, *attraction), inverse_square);
      attract(*pair, inverse_cube, inverse_square, *attraction, a);
    }
  }

  // The separation of two bodies; its square, softened.
  ATWOOD_INLINE static P separate(const GravitatingBodies::Pair& pair, const P* x, Attraction& now) {
    for (int c = 0; c < dimensions; ++c) now.r[c] = x[pair.b * dimensions + c] - x[pair.a * dimensions + c];
    return square(now.r) + pair.softening2_m2;
  }
  ATWOOD_INLINE static void attract(const GravitatingBodies::Pair& pair, const P& inverse_cube, const P& inverse_square,
                                    Attraction& now, P* a) {
    now.inverse_cube = inverse_cube;
    now.three_by_square = 3.0 * inverse_square;
    const P on_a = pair.on_a * inverse_cube, on_b = pair.on_b * inverse_cube;
    for (int c = 0; c < dimensions; ++c) {
      P& of_a = a[pair.a * dimensions + c];
      P& of_b = a[pair.b * dimensions + c];
      of_a = of_a + on_a * now.r[c];
      of_b = of_b - on_b * now.r[c];
    }
  }

  // The change of the accelerations with a change w of the positions.
  ATWOOD_INLINE void accelerate_along(const P* w, P* change) const {
    for_rows([&](int r, int) ATWOOD_INLINED { change[r] = P{}; });
    const Attraction* attraction = attractions_;
    P d[dimensions];
    for_centres([&](const GravitatingBodies::Centre& centre) ATWOOD_INLINED {
      const int at = of_centre(centre);
      (attraction++)->derive(w + at, d);
      for (int c = 0; c < dimensions; ++c) change[at + c] = change[at + c] - d[c];
    });
    if constexpr (known == 1) return;
    for (const GravitatingBodies::Pair& pair : system_.pairs) {
      const int first = pair.a * dimensions, second = pair.b * dimensions;
      P between[dimensions];
      for (int c = 0; c < dimensions; ++c) between[c] = w[second + c] - w[first + c];
      (attraction++)->derive(between, d);
      for (int c = 0; c < dimensions; ++c) {
        change[first + c] = change[first + c] + pair.on_a * d[c];
        change[second + c] = change[second + c] - pair.on_b * d[c];
      }
    }
  }

  // A sweep evaluates G(F), the rates at states that the rates F give. Newton's method would add (1 - L)^-1 (G(F) - F)
  // to F, where L = h^2 J a2 with the gradient J of gravity. The Neumann series of that inverse is taken to L^2, so
  // that a sweep leaves L^3 of the error in place of L, and the square of the error; or as far as the tolerance needs.
  ATWOOD_INLINE void sweep() {
    const bool predicted = step_.rate_from != nullptr;
    const Columns<P> twice(table_.a2, step_.h_s * step_.h_s);
    double weight = weight_of(rate_), linear = 1;  // linear: the largest |L D| / |D|
    radau::SweepEnd<double> end(step_.rtol, false, step_.contraction);
    for (bool first = true;; first = false) {
      P x[kRoom], a[kRoom];
      radau::LargestSize<P> most;
      for_rows([&](int r, int) ATWOOD_INLINED { x[r] = base_[r] + twice.combine(rate_[r]); });
      accelerate(x, a);
      for_rows([&](int r, int) ATWOOD_INLINED {
        const P change = a[r] - load_as<P>(rate_[r]);
        most.add(change);
        store<double>(change, residual_[r]);
      });
      const double now = weight * most.value();
      double left = now * real::max(linear, end.contraction);
      for (int power = 1; power <= kCorrections && !(left <= kCorrected * end.enough); ++power) {
        P along[kRoom];
        radau::LargestSize<P> moved;
        for_rows([&](int r, int) ATWOOD_INLINED { x[r] = twice.combine(residual_[r]); });
        accelerate_along(x, along);
        for_rows([&](int r, int) ATWOOD_INLINED {
          a[r] = a[r] + along[r];
          moved.add(along[r]);
          store<double>(along[r], residual_[r]);
        });
        if (power == 1) linear = moved.value() / most.value();
        left *= linear;
      }
      for_rows([&](int r, int) ATWOOD_INLINED { store<double>(a[r], rate_[r]); });
      const bool blind = first && !predicted;
      if (end.reached(now, blind)) break;
      if (blind) weight = weight_of(rate_);
    }
    step_.contraction = end.contraction;
    step_.report = end.report();
  }

  ATWOOD_INLINE double add(int i, double y, double increment) const {
    if (!step_.compensated) return y + increment;
    const double wanted = increment + step_.compensation[i], sum = y + wanted, part = sum - y;
    step_.compensation_new[i] = (y - (sum - part)) + (wanted - part);
    return sum;
  }

  ATWOOD_INLINE void finish() {
    const double h_s = step_.h_s;
    const Columns<P> columns(table_.ends, 1.0);
    const bool continued = step_.rate_from != nullptr && step_.offset == 1;
    for_rows([&](int r, int i) ATWOOD_INLINED {
      const std::ptrdiff_t at = (i + 3) * kNodes;
      const P rate = load_as<P>(rate_[r]), ends = columns.combine(rate_[r]);
      store<double>(rate, step_.rate + at);
      store<double>(continued ? rate - load_as<P>(predicted_[r]) : P{}, step_.prediction_error + at);
      step_.y_new[i] = add(i, step_.y[i], h_s * (step_.y[i + 3] + h_s * ends[1]));
      step_.y_new[i + 3] = add(i + 3, step_.y[i + 3], h_s * ends[0]);
      step_.last_coefficient = real::max(step_.last_coefficient, real::abs(ends[2]));
    });
  }

  ATWOOD_INLINE void keep_plane() {
    for (int b = 0; b < bodies_; ++b) {
      const int i = b * kBodySize + 2;
      for (double* array : {step_.rate, step_.prediction_error}) store<double>(P{}, array + (i + 3) * kNodes);
      for (const int at : {i, i + 3}) {
        step_.y_new[at] = step_.y[at];
        if (step_.compensated) step_.compensation_new[at] = 0;
      }
    }
  }

  const GravitatingBodies& system_;
  GravitatingStep& step_;
  const int bodies_;
  const RadauTable<double>& table_ = radau_table<double>();
  alignas(64) Rows rate_, residual_, predicted_;
  P base_[kRoom], field_[kRoom];
  Attraction attractions_[known == 1 ? 1 : kMaxCentres + kMaxPairs];
  double speed_ = 0;
};

template <int known, int dimensions>
void step_at(VectorWidth width, const GravitatingBodies& bodies, GravitatingStep& step) {
  in_lanes<double>(width,
                   [&](auto w) ATWOOD_INLINED { Kernel<decltype(w)::value, known, dimensions>(bodies, step).run(); });
}

}  // namespace

void step_gravitating_bodies(VectorWidth width, const GravitatingBodies& bodies, GravitatingStep& step) {
  const bool alone = bodies.count == 1 && bodies.centres.size() == 1;
  if (step.in_plane) return alone ? step_at<1, 2>(width, bodies, step) : step_at<0, 2>(width, bodies, step);
  return alone ? step_at<1, 3>(width, bodies, step) : step_at<0, 3>(width, bodies, step);
}

bool GravitatingBodies::in_plane(const double* y) const {
  const double z_m = y[2];
  for (int b = 0; b < count; ++b)
    if (y[b * kBodySize + 2] != z_m || y[b * kBodySize + 5] != 0 || field_m_per_s2[b][2] != 0) return false;
  return std::all_of(centres.begin(), centres.end(), [&](const Centre& centre) { return centre.at_m[2] == z_m; });
}

namespace {

// In the order of the scene, as the general rates add them. A fixed body of a pair is a centre.
void add_attraction(const SeriesForces<double>::InverseSquare& law, const RigidModel<double>& model,
                    const std::vector<int>& place, GravitatingBodies& bodies) {
  const auto centre_at = [&](int body, const Vec3<double>& at_m, double mu) {
    bodies.centres.push_back({body, {at_m.x, at_m.y, at_m.z}, mu, law.softening2, mu != 0 ? 3 / mu : 0});
  };
  const auto fixed_at = [&](int body) {
    std::vector<double> y(model.state_size());
    return model.body(body, y.data()).p_WB;
  };
  const int a = law.a < 0 ? -1 : place[law.a], b = place[law.b];
  if (a >= 0 && b >= 0) bodies.pairs.push_back({a, b, law.on_a, -law.on_b, law.softening2});
  else if (b >= 0) centre_at(b, law.a < 0 ? law.centre : fixed_at(law.a), -law.on_b);
  else if (a >= 0) centre_at(a, fixed_at(law.b), law.on_a);
}

}  // namespace

std::unique_ptr<GravitatingBodies> gravitating_bodies(const RigidModel<double>& model) {
  const SeriesForces<double>& forces = model.series_forces();
  if (model.bare_problem() || model.tree() != nullptr || !model.switch_times_s().empty()) return nullptr;
  if (!forces.refusal.empty() || !forces.links.empty() || !forces.oscillating.empty() || !forces.quadratic.empty())
    return nullptr;
  auto found = std::make_unique<GravitatingBodies>();
  std::vector<int> place(model.body_count(), -1);
  for (int body = 0; body < model.body_count(); ++body) {
    if (!forces.linear[body].none) return nullptr;
    if (model.offset(body) < 0) continue;
    if (model.rotates(body) || found->count == kMaxGravitating) return nullptr;
    store3(forces.linear[body].constant, found->field_m_per_s2[found->count]);
    place[body] = found->count++;
  }
  if (found->count == 0 || static_cast<int>(model.moving().size()) != found->count) return nullptr;
  for (const auto& law : forces.inverse_square) add_attraction(law, model, place, *found);
  if (found->centres.size() > kMaxCentres || found->pairs.size() > kMaxPairs) return nullptr;
  return found;
}

}  // namespace atwood
