// Tableaux of orders 1 to 4, without error estimates.
#include "integrators/tableaux.hpp"

// clang-format off: the rows of tables stand as they are printed in their sources

namespace atwood {

const Tableau explicit_euler_tableau{.stages = 1, .order = 1, .b = "1", .c = "0"};

// Runge 1895.
const Tableau midpoint_tableau{.stages = 2, .order = 2, .a = {"", "1/2"}, .b = "0 1", .c = "0 1/2"};

// Heun 1900, the trapezoidal one.
const Tableau heun_tableau{.stages = 2, .order = 2, .a = {"", "1"}, .b = "1/2 1/2", .c = "0 1"};

// Ralston, Math. Comp. 16 (1962) 431, eq. 3.5: the least bound on the local error of two stages.
const Tableau ralston2_tableau{.stages = 2, .order = 2, .a = {"", "2/3"}, .b = "1/4 3/4", .c = "0 2/3"};

// Kutta 1901, section 2.
const Tableau kutta3_tableau{.stages = 3, .order = 3, .a = {"", "1/2", "-1 2"}, .b = "1/6 2/3 1/6", .c = "0 1/2 1"};

// Kutta 1901: Hairer, Norsett, Wanner I, table II.1.2, left and right.
const Tableau rk4_tableau{
    .stages = 4, .order = 4, .a = {"", "1/2", "0 1/2", "0 0 1"}, .b = "1/6 1/3 1/3 1/6", .c = "0 1/2 1/2 1"};
const Tableau rk38_tableau{
    .stages = 4, .order = 4, .a = {"", "1/3", "-1/3 1", "1 -1 1"}, .b = "1/8 3/8 3/8 1/8", .c = "0 1/3 2/3 1"};

}  // namespace atwood
