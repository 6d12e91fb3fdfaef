#include "benchmarks/rates.hpp"

#include "validation/metrics/work_precision.hpp"

namespace atwood {

bool is_library(const std::string& engine) {
  return engine == "odeint" || engine == "arkode" || engine == "cvode" || engine == "ida";
}

bool runs_at_reference_rate(const std::string& method) {
  const std::string engine = engine_of(method);
  return engine == kSameRateEngine || is_library(engine);
}

}  // namespace atwood
