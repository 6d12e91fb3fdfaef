// Registers of four doubles or eight floats, for AVX2; math/pack.hpp has those of eight numbers.
#pragma once

#include "math/pack.hpp"

namespace atwood::fluid {

template <class S> struct RegisterOf {};
template <> struct RegisterOf<float> { using Type = FloatPack; };
template <> struct RegisterOf<double> { using Type = FourDoubles; };
// What a machine of this width holds in one register. Of the plain target as much, in two.
template <class S, VectorWidth width>
using Register = std::conditional_t<width == VectorWidth::v4, Pack<S>, typename RegisterOf<S>::Type>;

}  // namespace atwood::fluid
