// Sets of bodies that grow together (union-find): `parent[i]` is another body of i's set, or i, its root.
#pragma once

#include <algorithm>
#include <vector>

namespace atwood::stepping {

inline int root_of(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}
inline void join(std::vector<int>& parent, int a, int b) {  // the smaller number is the root
  const int x = root_of(parent, a), y = root_of(parent, b);
  parent[std::max(x, y)] = std::min(x, y);
}

}  // namespace atwood::stepping
