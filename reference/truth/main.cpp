#include <cstdio>
#include <cstring>

#include "closed_form/closed_form.hpp"
#include "fluid_truth/field.hpp"
#include "geometry/geometry.hpp"
#include "protocol/worker.hpp"
#include "truth/truth.hpp"

// With --solutions: the ids of the closed forms, one per line. The command line asks for them because it does not link
// the truths.
int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--solutions") == 0) {
    for (const std::string& id : atwood::closed_form_ids()) std::puts(id.c_str());
    for (const std::string& id : atwood::fluid_solution_ids()) std::puts(id.c_str());
    return 0;
  }
  return atwood::serve_truth(&atwood::solve_truth, ATWOOD_VERSION, &atwood::geometry::find_contacts,
                             {&atwood::geometry::pair_gap, true, {}}, &atwood::fluid_field_of);
}
