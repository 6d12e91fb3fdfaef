// What of this machine decides the last bits of a result, besides the code: processor features that choose among
// variants of a library's functions, and the version of the mathematical library.
#pragma once

#include <string>

namespace atwood {

// "sse4.1 avx avx2 fma avx512f", in this order, as far as the processor has them; then what GLIBC_TUNABLES says of the
// processor ("glibc.cpu.hwcaps=-AVX2_Usable"), which masks features for the libraries of this process and its workers.
std::string processor_features();
// "glibc 2.36"
std::string libm_version();
std::string machine_arithmetic();  // both: part of the hash of every cell

}  // namespace atwood
