// Which metrics are times of the computation: they differ in every run and belong to one machine.
#pragma once

#include <string_view>

namespace atwood {

// `figure`: a metric, or the name of a fluid's figure with its resolution ("run-time[dx=0.02,c=20]").
constexpr bool is_time(std::string_view figure) {
  return figure.starts_with("step-time") || figure.starts_with("run-time") || figure.starts_with("call-time-wasm") ||
         figure.starts_with("ns-per-particle-evaluation");
}

}  // namespace atwood
