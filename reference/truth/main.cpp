#include <cstdio>
#include <cstring>

#include "closed_form/closed_form.hpp"
#include "geometry/geometry.hpp"
#include "protocol/worker.hpp"
#include "truth/truth.hpp"

// With --solutions: the ids that a closed form's `solution` may name, one a line. The command line asks before it runs
// anything, as it does not link what it judges by.
int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--solutions") == 0) {
    for (const std::string& id : atwood::closed_form_ids()) std::puts(id.c_str());
    return 0;
  }
  return atwood::serve_truth(&atwood::solve_truth, ATWOOD_VERSION, &atwood::geometry::find_contacts,
                             {&atwood::geometry::pair_gap, true, {}});
}
