// The Butcher tables of ARKODE, by its own names.
#pragma once

#include <string>
#include <vector>

namespace atwood::arkode {

enum class Module { erkstep, arkstep_explicit, arkstep_implicit, arkstep_imex };

// One method of the library. Empty names: that half is not used.
struct Scheme {
  Module module = Module::erkstep;
  std::string name;                            // after the module: "DORMAND_PRINCE_7_4_5", "ARK324L2SA_4_2_3"
  std::string explicit_table, implicit_table;  // as ARKODE spells them: "ARKODE_DORMAND_PRINCE_7_4_5"
  int q = 0, p = 0;                            // order and order of the embedding, as the table says (0: no embedding)
  int stages = 0;
  int checked_order = 0;            // order by the library's check of the coefficients, which ends at 6
  bool last_node_is_one = false;    // c_s = 1 ...
  bool first_same_as_last = false;  // ... and a_sj = b_j: the last stage of a step is the first of the next
};

std::string to_string(Module module);  // "erkstep", "arkstep-explicit", ...
const std::vector<Scheme>& schemes();  // read from the linked library, once

}  // namespace atwood::arkode
