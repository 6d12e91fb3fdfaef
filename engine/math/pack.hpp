// Eight scalars that are added, multiplied and compared together: a vector register for float and double, an array for
// the wider scalars. Functions that take packs are always inlined, into a kernel of vector_width.hpp; files that use
// them are compiled with -Wno-psabi, as no pack is ever passed to a function that stands by itself.
#pragma once

#include <cstdint>

#include "math/lanes.hpp"

namespace atwood {

template <class S> struct WidePack {
  S lane[kLaneCount];
  S operator[](int k) const { return lane[k]; }
};
#define ATWOOD_PACK_OPERATION(op)                                                          \
  template <class S> WidePack<S> operator op(const WidePack<S>& a, const WidePack<S>& b) { \
    WidePack<S> out;                                                                       \
    for (int k = 0; k < kLaneCount; ++k) out.lane[k] = a.lane[k] op b.lane[k];             \
    return out;                                                                            \
  }                                                                                        \
  template <class S> WidePack<S> operator op(S a, const WidePack<S>& b) {                  \
    WidePack<S> out;                                                                       \
    for (int k = 0; k < kLaneCount; ++k) out.lane[k] = a op b.lane[k];                     \
    return out;                                                                            \
  }
ATWOOD_PACK_OPERATION(+)
ATWOOD_PACK_OPERATION(-)
ATWOOD_PACK_OPERATION(*)
#undef ATWOOD_PACK_OPERATION

using FloatPack = float __attribute__((vector_size(kLaneCount * sizeof(float))));
using DoublePack = double __attribute__((vector_size(kLaneCount * sizeof(double))));
template <class S> struct PackOf {
  using Type = WidePack<S>;
  static constexpr bool in_register = false;
};
template <> struct PackOf<float> {
  using Type = FloatPack;
  static constexpr bool in_register = true;
};
template <> struct PackOf<double> {
  using Type = DoublePack;
  static constexpr bool in_register = true;
};
template <class S> using Pack = typename PackOf<S>::Type;

// Two packs as one: eight doubles where a register holds four or two. GCC keeps a vector that is wider than the
// registers in memory, and copies it there in parts; so it does with a struct that it may copy as bytes.
template <class V> struct Halves {
  V low, high;
  Halves() = default;
  ATWOOD_INLINE Halves(const V& low_half, const V& high_half) : low(low_half), high(high_half) {}
  ATWOOD_INLINE explicit Halves(double everywhere) : low(all(everywhere)), high(low) {}
  ATWOOD_INLINE Halves(const Halves& other) : low(other.low), high(other.high) {}
  ATWOOD_INLINE Halves& operator=(const Halves& other) {
    low = other.low;
    high = other.high;
    return *this;
  }
  ATWOOD_INLINE double operator[](int k) const {
    constexpr int half = sizeof(V) / sizeof(double);
    return k < half ? low[k] : high[k - half];
  }

 private:
  ATWOOD_INLINE static V all(double value) {
    if constexpr (std::is_class_v<V>) return V(value);
    else return value - V{};  // keeps the sign of zero
  }
};
#define ATWOOD_HALVES_OPERATION(op)                                                                \
  template <class V> ATWOOD_INLINE Halves<V> operator op(const Halves<V>& a, const Halves<V>& b) { \
    return {a.low op b.low, a.high op b.high};                                                     \
  }                                                                                                \
  template <class V> ATWOOD_INLINE Halves<V> operator op(const Halves<V>& a, double b) {           \
    return {a.low op b, a.high op b};                                                              \
  }                                                                                                \
  template <class V> ATWOOD_INLINE Halves<V> operator op(double a, const Halves<V>& b) {           \
    return {a op b.low, a op b.high};                                                              \
  }
ATWOOD_HALVES_OPERATION(+)
ATWOOD_HALVES_OPERATION(-)
ATWOOD_HALVES_OPERATION(*)
ATWOOD_HALVES_OPERATION(/)
#undef ATWOOD_HALVES_OPERATION
template <class V> ATWOOD_INLINE Halves<V> operator-(const Halves<V>& a) { return {-a.low, -a.high}; }

// The pack in a kernel that is built for this width.
using TwoDoubles = double __attribute__((vector_size(16)));
using FourDoubles = double __attribute__((vector_size(32)));
template <class S, VectorWidth> struct PackAtWidth { using Type = Pack<S>; };
template <> struct PackAtWidth<double, VectorWidth::v3> { using Type = Halves<FourDoubles>; };
template <> struct PackAtWidth<double, VectorWidth::narrow> { using Type = Halves<Halves<TwoDoubles>>; };
template <class S, VectorWidth width> using PackAt = typename PackAtWidth<S, width>::Type;
template <class P> using LaneOf = std::decay_t<decltype(std::declval<P>()[0])>;

// Integers of as many bits as the lanes of a vector have, for its bits. (GCC drops the attribute of a vector type that
// depends on a template's parameter.)
template <class V> struct Integers {};
#define ATWOOD_INTEGERS(V, unsigned_lane, signed_lane)                      \
  template <> struct Integers<V> {                                          \
    using Unsigned = unsigned_lane __attribute__((vector_size(sizeof(V)))); \
    using Signed = signed_lane __attribute__((vector_size(sizeof(V))));     \
  };
ATWOOD_INTEGERS(FloatPack, std::uint32_t, std::int32_t)
ATWOOD_INTEGERS(DoublePack, std::uint64_t, std::int64_t)
ATWOOD_INTEGERS(FourDoubles, std::uint64_t, std::int64_t)
ATWOOD_INTEGERS(TwoDoubles, std::uint64_t, std::int64_t)
#undef ATWOOD_INTEGERS
template <class To, class From> ATWOOD_INLINE To bits_as(const From& from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  __builtin_memcpy(&to, &from, sizeof(to));
  return to;
}

template <class P> struct Memory {
  ATWOOD_INLINE static P load(const LaneOf<P>* at) {
    P pack;
    __builtin_memcpy(&pack, at, sizeof(pack));
    return pack;
  }
  ATWOOD_INLINE static void store(const P& pack, LaneOf<P>* at) { __builtin_memcpy(at, &pack, sizeof(pack)); }
};
template <class V> struct Memory<Halves<V>> {
  static constexpr std::ptrdiff_t kHalf = sizeof(V) / sizeof(double);
  ATWOOD_INLINE static Halves<V> load(const double* at) { return {Memory<V>::load(at), Memory<V>::load(at + kHalf)}; }
  ATWOOD_INLINE static void store(const Halves<V>& pack, double* at) {
    Memory<V>::store(pack.low, at);
    Memory<V>::store(pack.high, at + kHalf);
  }
};
template <class P> ATWOOD_INLINE P load_as(const LaneOf<P>* at) { return Memory<P>::load(at); }
template <VectorWidth width, class S> ATWOOD_INLINE PackAt<S, width> load_at(const S* at) {
  return load_as<PackAt<S, width>>(at);
}
template <class S> ATWOOD_INLINE Pack<S> load(const S* at) { return load_as<Pack<S>>(at); }
template <class S, class P> ATWOOD_INLINE void store(const P& pack, S* at) { Memory<P>::store(pack, at); }
template <class S> ATWOOD_INLINE Pack<S> broadcast(S value) {
  if constexpr (!PackOf<S>::in_register) {
    Pack<S> pack;
    for (S& lane : pack.lane) lane = value;
    return pack;
  } else {
    return Pack<S>{value, value, value, value, value, value, value, value};
  }
}

template <VectorWidth width, class S> ATWOOD_INLINE PackAt<S, width> broadcast_at(S value) {
  if constexpr (std::is_same_v<PackAt<S, width>, Pack<S>>) return broadcast(value);
  else return PackAt<S, width>(value);
}

// x where a > b; y elsewhere, and where a or b is NaN.
template <class P> ATWOOD_INLINE P where_above(const P& a, const P& b, const P& x, const P& y) { return a > b ? x : y; }
template <class V>
ATWOOD_INLINE Halves<V> where_above(const Halves<V>& a, const Halves<V>& b, const Halves<V>& x, const Halves<V>& y) {
  return {where_above(a.low, b.low, x.low, y.low), where_above(a.high, b.high, x.high, y.high)};
}

// All lanes at once, in a kernel built for this width: what a law or a loop may take instead of the number of a lane.
template <VectorWidth width> struct WholePack {};

// Square root in lane k. There is no operator for a pack's; GCC makes scalar code of a loop over its lanes (clang makes
// vectors of it, and takes no register of 256 bits outside a function of that target).
template <class S> ATWOOD_INLINE S root(int, S a) { return real::sqrt(a); }
template <class V, VectorWidth width> ATWOOD_INLINE Halves<V> root(WholePack<width> whole, const Halves<V>& a) {
  return {root(whole, a.low), root(whole, a.high)};
}
template <class P, VectorWidth width> ATWOOD_INLINE P root(WholePack<width>, const P& a) {
  P root_of_a;
#if defined(__x86_64__) && !defined(__clang__)
  constexpr bool of_doubles = std::is_same_v<LaneOf<P>, double>;
  if constexpr (sizeof(P) == 64 && width == VectorWidth::v4) {
    asm("vsqrtpd %1, %0" : "=v"(root_of_a) : "v"(a));
    return root_of_a;
  }
  if constexpr (sizeof(P) == 32 && width != VectorWidth::narrow) {
    if constexpr (of_doubles) asm("vsqrtpd %1, %0" : "=x"(root_of_a) : "x"(a));
    else asm("vsqrtps %1, %0" : "=x"(root_of_a) : "x"(a));
    return root_of_a;
  }
  if constexpr (sizeof(P) == 16 && of_doubles) {
    asm("sqrtpd %1, %0" : "=x"(root_of_a) : "x"(a));
    return root_of_a;
  }
#endif
  constexpr int lanes = sizeof(P) / sizeof(LaneOf<P>);
  for (int k = 0; k < lanes; ++k) root_of_a[k] = real::sqrt(a[k]);
  return root_of_a;
}

// Component c of the lane, or of the pack, at at[c * stride].
template <class S> ATWOOD_INLINE Vec3<S> load3(const S* at, std::ptrdiff_t stride, int k) {
  return load3(at + k, stride);
}
template <class S> ATWOOD_INLINE Quat<S> load4(const S* at, std::ptrdiff_t stride, int k) {
  return load4(at + k, stride);
}
template <class S> ATWOOD_INLINE void store3(const Vec3<S>& a, S* at, std::ptrdiff_t stride, int k) {
  store3(a, at + k, stride);
}
template <class S> ATWOOD_INLINE void store4(const Quat<S>& a, S* at, std::ptrdiff_t stride, int k) {
  store4(a, at + k, stride);
}
template <class S, VectorWidth width>
ATWOOD_INLINE Vec3<PackAt<S, width>> load3(const S* at, std::ptrdiff_t stride, WholePack<width>) {
  using P = PackAt<S, width>;
  return {load_as<P>(at), load_as<P>(at + stride), load_as<P>(at + 2 * stride)};
}
template <class S, VectorWidth width>
ATWOOD_INLINE Quat<PackAt<S, width>> load4(const S* at, std::ptrdiff_t stride, WholePack<width>) {
  using P = PackAt<S, width>;
  return {load_as<P>(at), load_as<P>(at + stride), load_as<P>(at + 2 * stride), load_as<P>(at + 3 * stride)};
}
template <class S, class V, VectorWidth width>
ATWOOD_INLINE void store3(const Vec3<V>& a, S* at, std::ptrdiff_t stride, WholePack<width>) {
  store<S>(a.x, at);
  store<S>(a.y, at + stride);
  store<S>(a.z, at + 2 * stride);
}
template <class S, class V, VectorWidth width>
ATWOOD_INLINE void store4(const Quat<V>& a, S* at, std::ptrdiff_t stride, WholePack<width>) {
  store<S>(a.w, at);
  store<S>(a.x, at + stride);
  store<S>(a.y, at + 2 * stride);
  store<S>(a.z, at + 3 * stride);
}

// f(k) for each lane, or f(WholePack) where the lanes are a full register.
template <class S, VectorWidth width, class F> ATWOOD_INLINE void for_packs(int count, const F& f) {
  if constexpr (PackOf<S>::in_register)
    if (count == kLaneCount) return f(WholePack<width>{});
  for (int k = 0; k < count; ++k) f(k);
}

}  // namespace atwood
