// Greedy colouring of the contact graph (bodies are nodes, contacts edges): each contact takes the first colour that
// neither of its moving bodies has, so that no two contacts of a colour share a moving body.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace atwood::stepping {

inline constexpr int kColourCount = 64;

struct GraphColouring {
  std::vector<std::uint64_t> used;  // by body: a bit for each colour of its contacts

  // The colour of the next contact; kColourCount: none is left. `b_moves`: else only a is taken into account.
  int assign(int a, int b, bool b_moves) {
    const std::uint64_t taken = used[a] | (b_moves ? used[b] : 0);
    const int colour = std::countr_one(taken);
    if (colour >= kColourCount) return kColourCount;
    used[a] |= std::uint64_t(1) << colour;
    if (b_moves) used[b] |= std::uint64_t(1) << colour;
    return colour;
  }
};

}  // namespace atwood::stepping
