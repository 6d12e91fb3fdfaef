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

// Component i of state k at y[i * stride + k], its time at t_s[k].
template <class S> struct StateLanes {
  using Value = Pack<S>;
  const S *t_s, *y;
  S* dydt;
  std::ptrdiff_t stride;
  ATWOOD_INLINE Pack<S> time() const { return load(t_s); }
  ATWOOD_INLINE Pack<S> at(int i) const { return load(y + i * stride); }
  ATWOOD_INLINE void set(int i, const Pack<S>& rate) const { store<S>(rate, dydt + i * stride); }
  ATWOOD_INLINE void add(int i, const Pack<S>& rate) const { set(i, load(dydt + i * stride) + rate); }
};

// A constant of the mechanism in all lanes.
template <class V, class S> ATWOOD_INLINE V in_all_lanes(S value) {
  if constexpr (std::is_same_v<V, S>) return value;
  else return broadcast(value);
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

}  // namespace atwood
