// The in-house engine as a worker process.
#include <cstdio>

#include "collision/box_edge_crossings.hpp"
#include "collision/query.hpp"
#include "math/vector_width.hpp"
#include "protocol/worker.hpp"
#include "simulation.hpp"

int main() {
  if (!atwood::knows_asked_width()) {
    std::fputs("ATWOOD_VECTOR_WIDTH: expected narrow, v3 or v4\n", stderr);
    return 2;
  }
  return atwood::serve(atwood::atwood_engine(),
                       {&atwood::find_pair_gap, false, {{"box-edges", atwood::find_contacts_by_box_edges}}});
}
