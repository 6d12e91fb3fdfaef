// Steppers of pairs (q, p): the symplectic ones, for q' = p and p' = f(q); velocity Verlet, for p' = f(q, p, t).
#include <algorithm>
#include <boost/numeric/odeint/stepper/symplectic_euler.hpp>
#include <boost/numeric/odeint/stepper/symplectic_rkn_sb3a_m4_mclachlan.hpp>
#include <boost/numeric/odeint/stepper/symplectic_rkn_sb3a_mclachlan.hpp>
#include <boost/numeric/odeint/stepper/velocity_verlet.hpp>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

namespace {

namespace lib = boost::numeric::odeint;
using stepping::Equations;
using stepping::Failure;

// The accelerations from the full rate; y = (q, p).
template <class S> struct Acceleration {
  const Equations<S>* equations;
  std::vector<S>* y;
  std::vector<S>* dydt;
  void evaluate(const std::vector<S>& q, const std::vector<S>& p, std::vector<S>& a, S t) const {
    const int n = equations->positions;
    std::copy_n(q.begin(), n, y->begin());
    std::copy_n(p.begin(), n, y->begin() + n);
    equations->rate(t, y->data(), dydt->data());
    std::copy_n(dydt->begin() + n, n, a.begin());
  }
  void operator()(const std::vector<S>& q, std::vector<S>& a) const {
    evaluate(q, q, a, 0);
  }  // independent of velocities
  void operator()(const std::vector<S>& q, const std::vector<S>& p, std::vector<S>& a, S t) const {
    evaluate(q, p, a, t);
  }
};

template <class S> class Pairs : public stepping::Stepper<S> {
 public:
  Pairs(const Equations<S>& equations, const std::vector<S>& y)
      : n_(equations.positions), y_(y), dydt_(y.size()), force_{&equations, &y_, &dydt_} {
    if (n_ == 0)
      throw Failure(Status::unsupported,
                    "this stepper integrates positions and velocities only; the scene has further unknowns");
    q_.assign(y.begin(), y.begin() + n_);
    p_.assign(y.begin() + n_, y.end());
  }
  std::int64_t advance(S, S, std::vector<S>&) override {
    throw Failure(Status::unsupported, "this stepper has no error control: expected equal steps without a tolerance");
  }

 protected:
  void give(std::vector<S>& y) const {
    std::copy(q_.begin(), q_.end(), y.begin());
    std::copy(p_.begin(), p_.end(), y.begin() + n_);
  }
  int n_;
  std::vector<S> y_, dydt_, q_, p_;
  Acceleration<S> force_;
};

template <class S, class Odeint> class Symplectic : public Pairs<S> {
 public:
  Symplectic(const Equations<S>& equations, const std::vector<S>& y, const Choice& choice)
      : Pairs<S>(equations, y), in_place_(choice.in_place) {
    if (equations.velocity_dependent)
      throw Failure(Status::unsupported, "a symplectic stepper requires f(q); the forces depend on velocities");
    if (equations.time_dependent)
      throw Failure(Status::unsupported, "a symplectic stepper requires f(q) without time; the forces depend on time");
    state_ = {this->q_, this->p_};
    out_ = state_;
  }
  void step(S t_s, S h_s, std::vector<S>& y) override {
    if (in_place_) {
      stepper_.do_step(this->force_, state_, t_s, h_s);
    } else {
      stepper_.do_step(this->force_, state_, t_s, out_, h_s);
      state_.swap(out_);
    }
    this->q_ = state_.first;
    this->p_ = state_.second;
    this->give(y);
  }

 private:
  Odeint stepper_;
  std::pair<std::vector<S>, std::vector<S>> state_, out_;
  bool in_place_;
};

template <class S> class Verlet : public Pairs<S> {
 public:
  Verlet(const Equations<S>& equations, const std::vector<S>& y, const Choice& choice)
      : Pairs<S>(equations, y), a_(this->n_), in_place_(choice.in_place) {
    state_ = {this->q_, this->p_};
    q_out_ = p_out_ = a_out_ = a_;
  }
  void step(S t_s, S h_s, std::vector<S>& y) override {
    if (in_place_) {
      stepper_.do_step(this->force_, state_, t_s, h_s);
      this->q_ = state_.first;
      this->p_ = state_.second;
    } else {
      if (!started_) this->force_(this->q_, this->p_, a_, t_s);
      started_ = true;
      stepper_.do_step(this->force_, this->q_, this->p_, a_, q_out_, p_out_, a_out_, t_s, h_s);
      this->q_.swap(q_out_);
      this->p_.swap(p_out_);
      a_.swap(a_out_);
    }
    this->give(y);
  }

 private:
  lib::velocity_verlet<std::vector<S>, std::vector<S>, S> stepper_;
  std::pair<std::vector<S>, std::vector<S>> state_;
  std::vector<S> a_, q_out_, p_out_, a_out_;
  bool in_place_, started_ = false;
};

template <class S, class Odeint>
std::unique_ptr<stepping::Stepper<S>> make_symplectic(const Equations<S>& equations, const std::vector<S>& y, S,
                                                      const Choice& choice) {
  return std::make_unique<Symplectic<S, Odeint>>(equations, y, choice);
}
template <class S>
std::unique_ptr<stepping::Stepper<S>> make_verlet(const Equations<S>& equations, const std::vector<S>& y, S,
                                                  const Choice& choice) {
  return std::make_unique<Verlet<S>>(equations, y, choice);
}

template <class S> using Euler = lib::symplectic_euler<std::vector<S>, std::vector<S>, S>;
template <class S> using Sb3a = lib::symplectic_rkn_sb3a_mclachlan<std::vector<S>, std::vector<S>, S>;
template <class S> using Sb3aM4 = lib::symplectic_rkn_sb3a_m4_mclachlan<std::vector<S>, std::vector<S>, S>;

template <template <class> class Of> Entry symplectic(const std::string& name, const std::string& doc) {
  Entry made;
  made.name = name;
  made.type = name + "<state, state, real>";
  made.doc = doc;
  made.claim = "its order()";
  made.order = Of<double>().order();
  made.form = Entry::Form::symplectic;
  made.in_double = make_symplectic<double, Of<double>>;
  made.in_long_double = make_symplectic<long double, Of<long double>>;
  return made;
}

}  // namespace

void add_symplectic(std::vector<Entry>& all) {
  all.push_back(symplectic<Euler>("symplectic_euler", "Symplectic Euler: drift, then kick."));
  all.push_back(symplectic<Sb3a>("symplectic_rkn_sb3a_mclachlan",
                                 "McLachlan's symplectic Runge-Kutta-Nystrom SB3A of six stages."));
  all.push_back(symplectic<Sb3aM4>("symplectic_rkn_sb3a_m4_mclachlan",
                                   "McLachlan's symplectic Runge-Kutta-Nystrom SB3A of five stages."));
  Entry verlet;
  verlet.name = "velocity_verlet";
  verlet.type = "velocity_verlet<state, state, real>";
  verlet.doc = "Velocity Verlet; odeint gives the force the velocities at the start of the step.";
  verlet.claim = "its order()";
  verlet.order = lib::velocity_verlet<std::vector<double>>().order();
  verlet.form = Entry::Form::verlet;
  verlet.in_double = make_verlet<double>;
  verlet.in_long_double = make_verlet<long double>;
  all.push_back(verlet);
}

}  // namespace atwood::odeint
