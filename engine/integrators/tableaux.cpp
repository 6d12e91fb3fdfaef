#include "integrators/tableaux.hpp"

namespace atwood {

//  0 |
//    | 1
constexpr Tableau explicit_euler{.stages = 1, .order = 1, .b = {{{1}}}};

//  0   |
//  1/2 | 1/2
//      |  0   1
constexpr Tableau midpoint{.stages = 2, .order = 2, .a = {{{}, {{{1, 2}}}}}, .b = {{{0}, {1}}}, .c = {{{0}, {1, 2}}}};

//  0 |
//  1 |  1
//    | 1/2 1/2
constexpr Tableau heun{.stages = 2, .order = 2, .a = {{{}, {{{1}}}}}, .b = {{{1, 2}, {1, 2}}}, .c = {{{0}, {1}}}};

//  0   |
//  1/2 | 1/2
//  1/2 |  0  1/2
//   1  |  0   0   1
//      | 1/6 1/3 1/3 1/6
constexpr Tableau rk4{.stages = 4,
                      .order = 4,
                      .a = {{{}, {{{1, 2}}}, {{{0}, {1, 2}}}, {{{0}, {0}, {1}}}}},
                      .b = {{{1, 6}, {1, 3}, {1, 3}, {1, 6}}},
                      .c = {{{0}, {1, 2}, {1, 2}, {1}}}};

// Fehlberg, NASA TR R-315 (1969), Table III: the order-4 weights advance, the order-5 weights judge.
constexpr Tableau fehlberg45{
    .stages = 6,
    .order = 4,
    .embedded_order = 5,
    .a = {{{},
           {{{1, 4}}},
           {{{3, 32}, {9, 32}}},
           {{{1932, 2197}, {-7200, 2197}, {7296, 2197}}},
           {{{439, 216}, {-8}, {3680, 513}, {-845, 4104}}},
           {{{-8, 27}, {2}, {-3544, 2565}, {1859, 4104}, {-11, 40}}}}},
    .b = {{{25, 216}, {0}, {1408, 2565}, {2197, 4104}, {-1, 5}}},
    .c = {{{0}, {1, 4}, {3, 8}, {12, 13}, {1}, {1, 2}}},
    .error_weight = {{{-1, 360}, {0}, {128, 4275}, {2197, 75240}, {-1, 50}, {-2, 55}}}};

// Dormand and Prince, J. Comput. Appl. Math. 6 (1980) 19, Table 2 (RK5(4)7M); continuous extension by Shampine as in
// Hairer, Norsett, Wanner I, eq. II.6.12 and the code DOPRI5.
constexpr Tableau dormand_prince5{
    .stages = 7,
    .order = 5,
    .embedded_order = 4,
    .a = {{{},
           {{{1, 5}}},
           {{{3, 40}, {9, 40}}},
           {{{44, 45}, {-56, 15}, {32, 9}}},
           {{{19372, 6561}, {-25360, 2187}, {64448, 6561}, {-212, 729}}},
           {{{9017, 3168}, {-355, 33}, {46732, 5247}, {49, 176}, {-5103, 18656}}},
           {{{35, 384}, {0}, {500, 1113}, {125, 192}, {-2187, 6784}, {11, 84}}}}},
    .b = {{{35, 384}, {0}, {500, 1113}, {125, 192}, {-2187, 6784}, {11, 84}, {0}}},
    .c = {{{0}, {1, 5}, {3, 10}, {4, 5}, {8, 9}, {1}, {1}}},
    .error_weight = {{{71, 57600}, {0}, {-71, 16695}, {71, 1920}, {-17253, 339200}, {22, 525}, {-1, 40}}},
    .first_same_as_last = true,
    .dense_weight = {{{-12715105075, 11282082432},
                      {0},
                      {87487479700, 32700410799},
                      {-10690763975, 1880347072},
                      {701980252875, 199316789632},
                      {-1453857185, 822651844},
                      {69997945, 29380423}}},
    .dense = true};

const Tableau explicit_euler_tableau = explicit_euler;
const Tableau midpoint_tableau = midpoint;
const Tableau heun_tableau = heun;
const Tableau rk4_tableau = rk4;
const Tableau fehlberg45_tableau = fehlberg45;
const Tableau dormand_prince5_tableau = dormand_prince5;

}  // namespace atwood
