// Dual numbers a + b e, e^2 = 0: a value and its derivative along one direction, by the rules of differentiation alone.
// A function template over the scalar, given duals, returns its derivative to round-off, without a step (forward-mode
// automatic differentiation; Griewank, Walther, Evaluating Derivatives, 2nd ed. (2008), chapter 3).
//
// Qualified names such as real::sqrt are looked up where a template is written, not where it is used: a file that
// instantiates the engine's templates for duals includes this header first.
#pragma once

#include "math/scalar.hpp"

namespace atwood {

template <class T> struct Dual {
  T value{}, slope{};
  Dual() = default;
  Dual(T constant) : value(constant) {}
  Dual(T of, T derivative) : value(of), slope(derivative) {}

  Dual operator-() const { return {-value, -slope}; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const T ratio = a.value / b.value;
    return {ratio, (a.slope - ratio * b.slope) / b.value};
  }
  // Of the values alone: a branch is taken as without derivatives.
  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
};

namespace real {

template <class T> Dual<T> sqrt(const Dual<T>& x) {
  const T root = sqrt(x.value);
  return {root, x.slope / (T(2) * root)};
}
template <class T> void sin_cos(const Dual<T>& x, Dual<T>& sine, Dual<T>& cosine) {
  T s, c;
  sin_cos(x.value, s, c);
  sine = {s, c * x.slope};
  cosine = {c, -s * x.slope};
}
template <class T> Dual<T> cos(const Dual<T>& x) { return {cos(x.value), -sin(x.value) * x.slope}; }

}  // namespace real
}  // namespace atwood
