// The scalars the engine computes in: float, double, long double, and __float128 ("quad").
//
// std:: has no overloads for quad, and argument-dependent lookup finds nothing for built-in types, so the functions
// that the engine needs are declared here for all four. Those of float and double have the same bits on every
// processor, which the C library's have not (math/elementary.hpp, math/sin_cos.hpp).
#pragma once

#include <cmath>

namespace atwood {

using Quad = __float128;

namespace real {

inline float sqrt(float x) { return std::sqrt(x); }
inline double sqrt(double x) { return std::sqrt(x); }
inline long double sqrt(long double x) { return std::sqrt(x); }
Quad sqrt(Quad x);

float sin(float x);
double sin(double x);
inline long double sin(long double x) { return std::sin(x); }
Quad sin(Quad x);

float cos(float x);
double cos(double x);
inline long double cos(long double x) { return std::cos(x); }
Quad cos(Quad x);

// Both at once, for the price of one and a little (sincos is an extension of glibc).
void sin_cos(float x, float& sine, float& cosine);
void sin_cos(double x, double& sine, double& cosine);
inline void sin_cos(long double x, long double& sine, long double& cosine) { ::sincosl(x, &sine, &cosine); }
void sin_cos(Quad x, Quad& sine, Quad& cosine);

float atan2(float y, float x);
double atan2(double y, double x);
inline long double atan2(long double y, long double x) { return std::atan2(y, x); }
Quad atan2(Quad y, Quad x);

inline float floor(float x) { return std::floor(x); }
inline double floor(double x) { return std::floor(x); }
inline long double floor(long double x) { return std::floor(x); }
Quad floor(Quad x);

template <class S> S abs(S x) { return x < S(0) ? -x : x; }
template <class S> S max(S a, S b) { return a < b ? b : a; }
template <class S> S min(S a, S b) { return b < a ? b : a; }
template <class S> bool is_finite(S x) { return x - x == S(0); }

// Distance from 1 to the next scalar.
template <class S> constexpr S epsilon();
template <> constexpr float epsilon<float>() { return 0x1p-23f; }
template <> constexpr double epsilon<double>() { return 0x1p-52; }
template <> constexpr long double epsilon<long double>() { return 0x1p-63L; }
template <> constexpr Quad epsilon<Quad>() { return 0x1p-112; }

}  // namespace real
}  // namespace atwood
