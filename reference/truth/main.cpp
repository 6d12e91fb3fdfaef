#include "geometry/geometry.hpp"
#include "protocol/worker.hpp"
#include "truth/truth.hpp"

int main() {
  return atwood::serve_truth(&atwood::solve_truth, ATWOOD_VERSION, &atwood::geometry::find_contacts,
                             {&atwood::geometry::pair_gap, true, {}});
}
