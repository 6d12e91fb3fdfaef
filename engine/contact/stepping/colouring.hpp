// Colours of contacts: each takes the first that neither of its moving bodies has, so a colour touches no moving body
// twice.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace atwood::stepping {

inline constexpr int kColourCount = 64;

struct Palette {
  std::vector<std::uint64_t> used;  // a bit a colour, a word a body

  int take(int a, int b, bool b_moves) {  // colour_count: none left
    const std::uint64_t taken = used[a] | (b_moves ? used[b] : 0);
    const int colour = std::countr_one(taken);
    if (colour >= kColourCount) return kColourCount;
    used[a] |= std::uint64_t(1) << colour;
    if (b_moves) used[b] |= std::uint64_t(1) << colour;
    return colour;
  }
};

}  // namespace atwood::stepping
