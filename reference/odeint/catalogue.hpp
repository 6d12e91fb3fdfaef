// The steppers of odeint in groups, one per file because its templates compile slowly: each group adds its entries to a
// list. Only the groups include Boost's headers.
#pragma once

#include <string>
#include <vector>

#include "stepping/stepping.hpp"

namespace atwood::odeint {

// The settings of a method id.
struct Choice {
  bool in_place = false;
  double rtol = 0, atol = 0;  // of the forms that take a tolerance
  double epsilon = 1e-6;      // implicit_euler's own default
};

template <class S>
using Make = std::unique_ptr<stepping::Stepper<S>> (*)(const stepping::Equations<S>&, const std::vector<S>& y, S h_s,
                                                       const Choice&);

struct Entry {
  std::string name, type;  // "runge_kutta4", "runge_kutta4<state, real>": as a program writes it
  std::string doc;
  std::string claim;  // where the claim comes from
  int order = 0;      // 0: no claim
  enum class Form { plain, controlled, dense, symplectic, verlet, implicit } form = Form::plain;
  bool by_tolerance = false;
  bool has_in_place = true;  // both do_step(sys, x, t, dt) and do_step(sys, in, t, out, dt)
  bool has_epsilon = false;
  Make<double> in_double = nullptr;
  Make<long double> in_long_double = nullptr;
};

void add_runge_kutta(std::vector<Entry>& all);
void add_adams_bashforth(std::vector<Entry>& all);
void add_adams_moulton(std::vector<Entry>& all);
void add_symplectic(std::vector<Entry>& all);
void add_controlled(std::vector<Entry>& all);
void add_implicit(std::vector<Entry>& all);

// The equations as the function object that odeint expects: system(x, dxdt, t).
template <class S> struct System {
  const stepping::Equations<S>* equations;
  void operator()(const std::vector<S>& x, std::vector<S>& dxdt, S t) const {
    equations->rate(t, x.data(), dxdt.data());
  }
};

// A stepper whose interface is do_step only.
template <class S, class Odeint> class Plain : public stepping::Stepper<S> {
 public:
  Plain(const stepping::Equations<S>& equations, const std::vector<S>& y, const Choice& choice)
      : system_{&equations}, out_(y.size()), in_place_(choice.in_place) {}
  void step(S t_s, S h_s, std::vector<S>& y) override {
    if (in_place_) {
      stepper_.do_step(system_, y, t_s, h_s);
    } else {
      stepper_.do_step(system_, y, t_s, out_, h_s);
      y.swap(out_);
    }
  }
  std::int64_t advance(S, S, std::vector<S>&) override {
    throw stepping::Failure(Status::unsupported,
                            "this stepper has no error control: it takes equal steps; found a tolerance");
  }

 private:
  System<S> system_;
  Odeint stepper_;
  std::vector<S> out_;
  bool in_place_;
};

template <class S, class Odeint>
std::unique_ptr<stepping::Stepper<S>> make_plain(const stepping::Equations<S>& equations, const std::vector<S>& y, S,
                                                 const Choice& choice) {
  return std::make_unique<Plain<S, Odeint>>(equations, y, choice);
}

// `Of<S>` is the stepper over std::vector<S>.
template <template <class> class Of>
Entry plain(const std::string& name, const std::string& type, const std::string& doc) {
  Entry made;
  made.name = name;
  made.type = type;
  made.doc = doc;
  made.claim = "its order()";
  made.order = Of<double>().order();
  made.in_double = make_plain<double, Of<double>>;
  made.in_long_double = make_plain<long double, Of<long double>>;
  return made;
}

}  // namespace atwood::odeint
