// Properties of this machine that decide the last bits of a result, besides the code: processor features by which
// libraries choose variants of their functions, and the version of the mathematical library.
#pragma once

#include <string>

namespace atwood {

// "sse4.1 avx avx2 fma avx512f", those that the processor has, in this order; then the entry of GLIBC_TUNABLES about
// the processor ("glibc.cpu.hwcaps=-AVX2_Usable"), which masks features for the libraries of this process and its
// workers.
std::string processor_features();
// "glibc 2.36"
std::string libm_version();
// The name of this host: times of two hosts are never taken together.
std::string host_name();
std::string machine_arithmetic();  // both: part of the hash of every cell

}  // namespace atwood
