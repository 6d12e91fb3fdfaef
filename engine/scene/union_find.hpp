// Disjoint sets of bodies (union-find): `parent[i]` is another body of i's set, or i itself where it is the root.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace atwood {

// The root of i's set; shortens the path to it (path halving).
inline int find_root(std::vector<int>& parent, int i) {
  const auto above = [&](int k) -> int& { return parent[static_cast<std::size_t>(k)]; };
  while (above(i) != i) i = above(i) = above(above(i));
  return i;
}
// Unites the sets of a and b; the smaller root becomes the root of both.
inline void unite(std::vector<int>& parent, int a, int b) {
  const int x = find_root(parent, a), y = find_root(parent, b);
  parent[static_cast<std::size_t>(std::max(x, y))] = std::min(x, y);
}

}  // namespace atwood
