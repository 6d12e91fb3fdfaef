#include "fluid_truth/kernel.hpp"

#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

KernelKind kernel_named(const std::string& name) {
  if (name == "cubic") return KernelKind::cubic;
  if (name == "quintic") return KernelKind::quintic;
  if (name == "wendland-c2") return KernelKind::wendland_c2;
  if (name == "wendland-c4") return KernelKind::wendland_c4;
  if (name == "wendland-c6") return KernelKind::wendland_c6;
  throw Refused{"expected the kernel cubic, quintic, wendland-c2, wendland-c4 or wendland-c6; found `" + name + "`"};
}

int support_of(KernelKind kind) { return kind == KernelKind::quintic ? 3 : 2; }

namespace {

template <class S> S power(S x, int n) {  // of the positive part
  if (!(x > 0)) return 0;
  S made = 1;
  for (int k = 0; k < n; ++k) made *= x;
  return made;
}

}  // namespace

template <class S> S Kernel<S>::shape(S s) const {
  const S u = 1 - s;
  switch (kind) {
    case KernelKind::cubic: return power(u, 3) - 4 * power(S(0.5) - s, 3);
    case KernelKind::quintic: return power(u, 5) - 6 * power(S(2) / 3 - s, 5) + 15 * power(S(1) / 3 - s, 5);
    case KernelKind::wendland_c2: return power(u, 4) * (1 + 4 * s);
    case KernelKind::wendland_c4: return power(u, 6) * (1 + 6 * s + S(35) / 3 * s * s);
    case KernelKind::wendland_c6: return power(u, 8) * (1 + 8 * s + 25 * s * s + 32 * s * s * s);
  }
  return 0;
}

// Slopes divided by s, without a division near s = 0. Wendland's: d/ds of (1-s)^4 (1 + 4 s) is -20 s (1-s)^3; of C4
// -56/3 s (1 + 5 s) (1-s)^5; of C6 -22 s (1 + 7 s + 16 s^2) (1-s)^7. The splines' inner parts are expanded below.
template <class S> S Kernel<S>::shape_slope_over_s(S s) const {
  const S u = 1 - s;
  switch (kind) {
    case KernelKind::cubic:
      // s < 1/2: (1-s)^2 - 4 (1/2-s)^2 = (1 - 2 s + s^2) - (1 - 4 s + 4 s^2) = 2 s - 3 s^2
      return s < S(0.5) ? -3 * (2 - 3 * s) : -3 * power(u, 2) / s;
    case KernelKind::quintic: {
      // s < 1/3: (1-s)^4 - 6 (2/3-s)^4 + 15 (1/3-s)^4: the constants and the odd terms of s cancel up to s^3:
      //   1 - 6 (16/81) + 15/81 = 0,   s: -4 + 6 4 (8/27) - 15 4 / 27 = 8/9,   s^2: 6 - 36 (4/9) + 90/9 = 0,
      //   s^3: -4 + 24 (2/3) - 60/3 = -8,   s^4: 1 - 6 + 15 = 10
      if (s < S(1) / 3) return -5 * (S(8) / 9 - 8 * s * s + 10 * s * s * s);
      return -5 * (power(u, 4) - 6 * power(S(2) / 3 - s, 4)) / s;
    }
    case KernelKind::wendland_c2: return -20 * power(u, 3);
    case KernelKind::wendland_c4: return -S(56) / 3 * (1 + 5 * s) * power(u, 5);
    case KernelKind::wendland_c6: return -22 * (1 + 7 * s + 16 * s * s) * power(u, 7);
  }
  return 0;
}

// N from the integral of w over the unit ball: 2 pi int w s ds, 4 pi int w s^2 ds.
template <class S> Kernel<S> kernel_of(KernelKind kind, int dimensions, S R) {
  const S turn = static_cast<S>(pi<Wide>());
  const bool plane = dimensions == 2;
  S N = 0;
  switch (kind) {
    case KernelKind::cubic: N = plane ? 80 / (7 * turn) : 16 / turn; break;
    case KernelKind::quintic: N = plane ? 15309 / (478 * turn) : 2187 / (40 * turn); break;
    case KernelKind::wendland_c2: N = plane ? 7 / turn : 21 / (2 * turn); break;
    case KernelKind::wendland_c4: N = plane ? 9 / turn : 495 / (32 * turn); break;
    case KernelKind::wendland_c6: N = plane ? 78 / (7 * turn) : 1365 / (64 * turn); break;
  }
  S volume = R * R;
  if (!plane) volume *= R;
  return {kind, dimensions, R, N / volume, N / (volume * R * R)};
}

template struct Kernel<double>;
template struct Kernel<Narrow>;
template struct Kernel<Wide>;
template Kernel<double> kernel_of(KernelKind, int, double);
template Kernel<Narrow> kernel_of(KernelKind, int, Narrow);
template Kernel<Wide> kernel_of(KernelKind, int, Wide);

}  // namespace atwood::fluid_truth
