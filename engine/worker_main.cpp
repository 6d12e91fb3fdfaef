// The in-house engine as a worker process.
#include "collision/box_edge_crossings.hpp"
#include "collision/query.hpp"
#include "protocol/worker.hpp"
#include "simulation.hpp"

int main() {
  return atwood::serve(atwood::atwood_engine(),
                       {&atwood::find_pair_gap, false, {{"box-edges", atwood::find_contacts_by_box_edges}}});
}
