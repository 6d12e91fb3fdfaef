// Steppers that solve linear systems, over uBLAS: Rosenbrock 4(3) in its three forms, and implicit Euler.
#include <boost/numeric/odeint/stepper/implicit_euler.hpp>
#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <boost/numeric/odeint/stepper/rosenbrock4_controller.hpp>
#include <boost/numeric/odeint/stepper/rosenbrock4_dense_output.hpp>

#include "odeint/catalogue.hpp"
#include "odeint/tolerance.hpp"

namespace atwood::odeint {

namespace {

namespace lib = boost::numeric::odeint;
using stepping::Equations;
template <class S> using Vector = boost::numeric::ublas::vector<S>;
template <class S> using Matrix = boost::numeric::ublas::matrix<S>;

// Evaluations allowed in a step, which normally takes a few: an iteration of the library that does not end is stopped.
constexpr int kMaxEvaluations = 1000;

template <class S> struct Rate {
  const Equations<S>* equations;
  int* evaluations;  // of this step so far; null: not counted
  void operator()(const Vector<S>& x, Vector<S>& dxdt, S t) const {
    if (evaluations != nullptr && ++*evaluations > kMaxEvaluations)
      throw stepping::Failure(Status::diverged,
                              "no end of its iteration after 1000 evaluations of f in the step to t = " +
                                  std::to_string(static_cast<double>(t)) + " s");
    equations->rate(t, &x[0], &dxdt[0]);
  }
};
template <class S> struct Jacobian {
  const Equations<S>* equations;
  void operator()(const Vector<S>& x, Matrix<S>& dfdx, S t, Vector<S>& dfdt) const {
    equations->jacobian(t, &x[0], &dfdx.data()[0], &dfdt[0]);  // row-major, as in uBLAS
  }
  void operator()(const Vector<S>& x, Matrix<S>& dfdx, S t) const {
    Vector<S> dfdt(x.size());
    (*this)(x, dfdx, t, dfdt);
  }
};
template <class S> using Pair = std::pair<Rate<S>, Jacobian<S>>;
template <class S> Pair<S> pair_of(const Equations<S>& equations, int* evaluations) {
  return {Rate<S>{&equations, evaluations}, Jacobian<S>{&equations}};
}

template <class S, class Odeint, bool has_out> class Implicit : public stepping::Stepper<S> {
 public:
  Implicit(const Equations<S>& equations, const std::vector<S>& y, Odeint stepper, bool in_place)
      : system_(pair_of(equations, &evaluations_)), stepper_(std::move(stepper)), x_(y.size()), out_(y.size()),
        in_place_(in_place) {}
  void step(S t_s, S h_s, std::vector<S>& y) override {
    evaluations_ = 0;
    std::copy(y.begin(), y.end(), x_.begin());
    if constexpr (has_out) {
      if (!in_place_) {
        stepper_.do_step(system_, x_, t_s, out_, h_s);
        std::copy(out_.begin(), out_.end(), y.begin());
        return;
      }
    }
    stepper_.do_step(system_, x_, t_s, h_s);
    std::copy(x_.begin(), x_.end(), y.begin());
  }
  std::int64_t advance(S, S, std::vector<S>&) override {
    throw stepping::Failure(Status::unsupported, "this stepper takes equal steps; found a tolerance");
  }

 private:
  int evaluations_ = 0;
  Pair<S> system_;
  Odeint stepper_;
  Vector<S> x_, out_;
  bool in_place_;
};

template <class S>
std::unique_ptr<stepping::Stepper<S>> make_rosenbrock(const Equations<S>& equations, const std::vector<S>& y, S,
                                                      const Choice& choice) {
  using Odeint = lib::rosenbrock4<S>;
  return std::make_unique<Implicit<S, Odeint, true>>(equations, y, Odeint(), choice.in_place);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_implicit_euler(const Equations<S>& equations, const std::vector<S>& y, S,
                                                          const Choice& choice) {
  using Odeint = lib::implicit_euler<S>;
  return std::make_unique<Implicit<S, Odeint, false>>(equations, y, Odeint(S(choice.epsilon)), true);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_controlled(const Equations<S>& equations, const std::vector<S>& y, S h_s,
                                                      const Choice& choice) {
  using Odeint = lib::rosenbrock4_controller<lib::rosenbrock4<S>>;
  return by_trial<S, Vector<S>>(pair_of(equations, nullptr), Odeint(S(choice.atol), S(choice.rtol)), y, h_s);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_dense(const Equations<S>& equations, const std::vector<S>& y, S h_s,
                                                 const Choice& choice) {
  using Controller = lib::rosenbrock4_controller<lib::rosenbrock4<S>>;
  using Odeint = lib::rosenbrock4_dense_output<Controller>;
  return by_dense_output<S, Vector<S>>(pair_of(equations, nullptr), Odeint(Controller(S(choice.atol), S(choice.rtol))),
                                       y, h_s);
}

}  // namespace

void add_implicit(std::vector<Entry>& all) {
  Entry plain;
  plain.name = "rosenbrock4";
  plain.type = "rosenbrock4<real>";
  plain.doc =
      "The Rosenbrock method RODAS of order 4, equal steps; Jacobian and df/dt by differences of the reference's "
      "equations.";
  plain.claim = "its order()";
  plain.order = lib::rosenbrock4<double>().order();
  plain.form = Entry::Form::implicit;
  plain.in_double = make_rosenbrock<double>;
  plain.in_long_double = make_rosenbrock<long double>;
  all.push_back(plain);

  Entry controlled = plain;
  controlled.name = "controlled/rosenbrock4";
  controlled.type = "rosenbrock4_controller<rosenbrock4<double>>(atol, rtol)";
  controlled.doc = "RODAS 4(3) with odeint's step control.";
  controlled.form = Entry::Form::controlled;
  controlled.by_tolerance = true;
  controlled.has_in_place = false;
  controlled.in_double = make_controlled<double>;
  controlled.in_long_double = make_controlled<long double>;
  all.push_back(controlled);

  Entry dense = controlled;
  dense.name = "dense_output/rosenbrock4";
  dense.type = "rosenbrock4_dense_output<rosenbrock4_controller<rosenbrock4<double>>>";
  dense.doc = "RODAS 4(3) with odeint's step control and dense output: samples are interpolated.";
  dense.form = Entry::Form::dense;
  dense.in_double = make_dense<double>;
  dense.in_long_double = make_dense<long double>;
  all.push_back(dense);

  Entry euler = plain;
  euler.name = "implicit_euler";
  euler.type = "implicit_euler<real>";
  euler.doc =
      "Implicit Euler with odeint's own Newton iteration, which ends when the norm of a correction is at most epsilon.";
  euler.claim = "odeint's documentation (steppers table): order 1; there is no order()";
  euler.order = 1;
  euler.has_in_place = false;
  euler.has_epsilon = true;
  euler.in_double = make_implicit_euler<double>;
  euler.in_long_double = make_implicit_euler<long double>;
  all.push_back(euler);
}

}  // namespace atwood::odeint
