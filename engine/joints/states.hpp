// Access of a kernel to one state, or to eight states in vector lanes.
#pragma once

#include <new>
#include <vector>

#include "math/pack.hpp"

namespace atwood {

template <class S> struct OneState {
  using Value = S;
  S t_s;
  const S* y;
  S* dydt;
  ATWOOD_INLINE S time() const { return t_s; }
  ATWOOD_INLINE S at(int i) const { return y[i]; }
  ATWOOD_INLINE void set(int i, S rate) const { dydt[i] = rate; }
  ATWOOD_INLINE void add(int i, S rate) const { dydt[i] += rate; }
};

// Component i of state k at y[i * stride + k], its time at t_s[k]. A kernel takes those of its width (at_width); the
// default P only names the pointers.
template <class S, class P = Pack<S>> struct StateLanes {
  using Value = P;
  const S *t_s, *y;
  S* dydt;
  std::ptrdiff_t stride;
  ATWOOD_INLINE P time() const { return load_as<P>(t_s); }
  ATWOOD_INLINE P at(int i) const { return load_as<P>(y + i * stride); }
  ATWOOD_INLINE void set(int i, const P& rate) const { store<S>(rate, dydt + i * stride); }
  ATWOOD_INLINE void add(int i, const P& rate) const { set(i, load_as<P>(dydt + i * stride) + rate); }
  template <VectorWidth width> ATWOOD_INLINE StateLanes<S, PackAt<S, width>> at_width() const {
    return {t_s, y, dydt, stride};
  }
};

// A constant of the mechanism in all lanes.
template <class V, class S> ATWOOD_INLINE V in_all_lanes(S value) {
  if constexpr (std::is_same_v<V, S>) return value;
  else if constexpr (std::is_same_v<V, Pack<S>>) return broadcast(value);
  else return V(value);
}

// Vectors of packs, and of structs of packs, at addresses that kernels of every width read whole registers from: code
// compiled for a narrower target assumes a smaller alignment of packs.
template <class T> struct RegisterAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};
  RegisterAllocator() = default;
  template <class U> RegisterAllocator(const RegisterAllocator<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), alignment)); }
  void deallocate(T* at, std::size_t) { ::operator delete(at, alignment); }
  template <class U> bool operator==(const RegisterAllocator<U>&) const { return true; }
};
template <class T> using RegisterVector = std::vector<T, RegisterAllocator<T>>;

// What a kernel over eight states works in: T of the pack of each width; all three are there, and one is used.
template <template <class> class T, class S> struct WorkInLanes {
  T<PackAt<S, VectorWidth::v4>> v4;
  T<PackAt<S, VectorWidth::v3>> v3;
  T<PackAt<S, VectorWidth::narrow>> narrow;

  template <class... Sizes> void resize(Sizes... sizes) {
    v4.resize(sizes...);
    v3.resize(sizes...);
    narrow.resize(sizes...);
  }
  template <VectorWidth width> auto& at() {
    if constexpr (width == VectorWidth::v4) return v4;
    else if constexpr (width == VectorWidth::v3) return v3;
    else return narrow;
  }
};

// One number for each lane and component, as `values[component]`.
template <class P> struct LaneValues {
  const LaneOf<P>* at;
  ATWOOD_INLINE P operator[](int i) const { return load_as<P>(at + static_cast<std::ptrdiff_t>(i) * kLaneCount); }
};

}  // namespace atwood
