#include "arkode/tables.hpp"

#include <arkode/arkode_butcher.h>
#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>

#include <array>

namespace atwood::arkode {

namespace {

// clang-format off
constexpr std::array kExplicit{
    "HEUN_EULER_2_1_2", "BOGACKI_SHAMPINE_4_2_3", "ARK324L2SA_ERK_4_2_3", "ZONNEVELD_5_3_4", "ARK436L2SA_ERK_6_3_4",
    "SAYFY_ABURUB_6_3_4", "CASH_KARP_6_4_5", "FEHLBERG_6_4_5", "DORMAND_PRINCE_7_4_5", "ARK548L2SA_ERK_8_4_5",
    "VERNER_8_5_6", "FEHLBERG_13_7_8", "KNOTH_WOLKE_3_3", "ARK437L2SA_ERK_7_3_4", "ARK548L2SAb_ERK_8_4_5"};
// clang-format on
// clang-format off
constexpr std::array kImplicit{
    "SDIRK_2_1_2", "BILLINGTON_3_3_2", "TRBDF2_3_3_2", "KVAERNO_4_2_3", "ARK324L2SA_DIRK_4_2_3", "CASH_5_2_4",
    "CASH_5_3_4", "SDIRK_5_3_4", "KVAERNO_5_3_4", "ARK436L2SA_DIRK_6_3_4", "KVAERNO_7_4_5", "ARK548L2SA_DIRK_8_4_5",
    "ARK437L2SA_DIRK_7_3_4", "ARK548L2SAb_DIRK_8_4_5", "ESDIRK324L2SA_4_2_3", "ESDIRK325L2SA_5_2_3",
    "ESDIRK32I5L2SA_5_2_3", "ESDIRK436L2SA_6_3_4", "ESDIRK43I6L2SA_6_3_4", "QESDIRK436L2SA_6_3_4",
    "ESDIRK437L2SA_7_3_4", "ESDIRK547L2SA_7_4_5", "ESDIRK547L2SA2_7_4_5"};
// clang-format on
// Additive pairs: name, explicit half, implicit half (same nodes, same weights).
constexpr std::array<std::array<const char*, 3>, 5> kPairs{{
    {"ARK324L2SA_4_2_3", "ARK324L2SA_ERK_4_2_3", "ARK324L2SA_DIRK_4_2_3"},
    {"ARK436L2SA_6_3_4", "ARK436L2SA_ERK_6_3_4", "ARK436L2SA_DIRK_6_3_4"},
    {"ARK437L2SA_7_3_4", "ARK437L2SA_ERK_7_3_4", "ARK437L2SA_DIRK_7_3_4"},
    {"ARK548L2SA_8_4_5", "ARK548L2SA_ERK_8_4_5", "ARK548L2SA_DIRK_8_4_5"},
    {"ARK548L2SAb_8_4_5", "ARK548L2SAb_ERK_8_4_5", "ARK548L2SAb_DIRK_8_4_5"},
}};

struct Table {  // owns one of the library's
  ARKodeButcherTable held;
  explicit Table(ARKodeButcherTable given) : held(given) {}
  ~Table() {
    if (held != nullptr) ARKodeButcherTable_Free(held);
  }
  Table(const Table&) = delete;
};

std::string full(const char* name) { return std::string("ARKODE_") + name; }

bool fill(const Table& table, Scheme& scheme) {
  if (table.held == nullptr) return false;  // a version without it
  scheme.q = table.held->q;
  scheme.p = table.held->d != nullptr ? table.held->p : 0;
  scheme.stages = table.held->stages;
  int q = 0, p = 0;
  ARKodeButcherTable_CheckOrder(table.held, &q, &p, nullptr);
  scheme.checked_order = q;
  const int last = scheme.stages - 1;
  scheme.last_node_is_one = table.held->c[last] == 1;
  scheme.first_same_as_last = scheme.last_node_is_one;
  for (int j = 0; j <= last; ++j) scheme.first_same_as_last &= table.held->A[last][j] == table.held->b[j];
  return true;
}

void add(std::vector<Scheme>& all, Module module, const char* name, const char* explicit_half,
         const char* implicit_half) {
  Scheme made;
  made.module = module;
  made.name = name;
  if (explicit_half != nullptr) made.explicit_table = full(explicit_half);
  if (implicit_half != nullptr) made.implicit_table = full(implicit_half);
  const Table e(explicit_half == nullptr ? nullptr : ARKodeButcherTable_LoadERKByName(made.explicit_table.c_str()));
  const Table i(implicit_half == nullptr ? nullptr : ARKodeButcherTable_LoadDIRKByName(made.implicit_table.c_str()));
  if (!fill(explicit_half != nullptr ? e : i, made)) return;
  if (module == Module::arkstep_imex) {
    if (i.held == nullptr) return;
    int q = 0, p = 0;
    ARKodeButcherTable_CheckARKOrder(e.held, i.held, &q, &p, nullptr);
    made.checked_order = q;
  }
  all.push_back(made);
}

std::vector<Scheme> read_all() {
  std::vector<Scheme> all;
  for (const char* name : kExplicit) add(all, Module::erkstep, name, name, nullptr);
  for (const char* name : kExplicit) add(all, Module::arkstep_explicit, name, name, nullptr);
  for (const char* name : kImplicit) add(all, Module::arkstep_implicit, name, nullptr, name);
  for (const auto& pair : kPairs) add(all, Module::arkstep_imex, pair[0], pair[1], pair[2]);
  return all;
}

}  // namespace

// Every table of the packaged library is named above; a later version's new ones are to be added.
#if !defined(ARKODE_AUDIT_NEWER)
static_assert(ARKODE_MAX_ERK_NUM - ARKODE_MIN_ERK_NUM + 1 >= static_cast<int>(kExplicit.size()));
static_assert(ARKODE_MAX_DIRK_NUM - ARKODE_MIN_DIRK_NUM + 1 >= static_cast<int>(kImplicit.size()));
#endif

std::string to_string(Module module) {
  switch (module) {
    case Module::erkstep: return "erkstep";
    case Module::arkstep_explicit: return "arkstep-explicit";
    case Module::arkstep_implicit: return "arkstep-implicit";
    case Module::arkstep_imex: return "arkstep-imex";
  }
  return "";
}

const std::vector<Scheme>& schemes() {
  static const std::vector<Scheme> all = read_all();
  return all;
}

}  // namespace atwood::arkode
