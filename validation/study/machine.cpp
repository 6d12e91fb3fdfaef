#include "validation/study/machine.hpp"

#include <gnu/libc-version.h>
#include <sys/auxv.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace atwood {
namespace {

std::string joined(const std::string& a, std::string_view b) { return a + (a.empty() ? "" : " ") + std::string(b); }

std::string instruction_sets() {
  std::string features;
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("sse4.1")) features = joined(features, "sse4.1");
  if (__builtin_cpu_supports("avx")) features = joined(features, "avx");
  if (__builtin_cpu_supports("avx2")) features = joined(features, "avx2");
  if (__builtin_cpu_supports("fma")) features = joined(features, "fma");
  if (__builtin_cpu_supports("fma4")) features = joined(features, "fma4");
  if (__builtin_cpu_supports("avx512f")) features = joined(features, "avx512f");
#else
  char text[64];
  std::snprintf(text, sizeof text, "hwcap=%lx,%lx", getauxval(AT_HWCAP), getauxval(AT_HWCAP2));
  features = text;
#endif
  return features;
}

}  // namespace

std::string processor_features() {
  std::string features = instruction_sets();
  const char* tunables = std::getenv("GLIBC_TUNABLES");
  for (std::string_view rest = tunables ? tunables : ""; !rest.empty();) {  // name=value:name=value
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (rest.substr(0, 10) == "glibc.cpu.") features = joined(features, rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return features;
}

std::string machine_arithmetic() { return processor_features() + "; " + libm_version(); }

std::string host_name() {
  struct utsname names {};
  return uname(&names) == 0 ? names.nodename : "unknown";
}

std::string libm_version() { return std::string("glibc ") + gnu_get_libc_version(); }

}  // namespace atwood
