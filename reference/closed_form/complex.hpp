// Complex numbers over long double and quad (std::complex leaves other types than the standard's open).
#pragma once

namespace atwood::closed_form {

template <class S> struct Complex { S re{}, im{}; };
template <class S> Complex<S> operator*(const Complex<S>& a, const Complex<S>& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class S> Complex<S> operator+(const Complex<S>& a, const Complex<S>& b) { return {a.re + b.re, a.im + b.im}; }
template <class S> Complex<S> scaled(S s, const Complex<S>& a) { return {s * a.re, s * a.im}; }
template <class S> Complex<S> conjugate(const Complex<S>& a) { return {a.re, -a.im}; }
template <class S> S square_of(const Complex<S>& a) { return a.re * a.re + a.im * a.im; }

}  // namespace atwood::closed_form
