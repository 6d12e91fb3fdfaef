// A truth's answer, judged by a checker's.
#pragma once

#include <string>

#include "number.hpp"
#include "protocol/truth.hpp"

namespace atwood::fuzz {

enum class Result { held, breach, refused, unchecked };

struct Judged {
  Result result = Result::held;
  double worst = 0;  // largest error in bars
  std::string reason;
};

// A value is left out if the checker's own error exceeds a tenth of the truth's bar, unless the truth breaches its bar
// by more than the checker's error. Any answer is a breach where the checker contradicts.
Judged judge(const Truth& truth, const Checked& exact, double t_end_s);

}  // namespace atwood::fuzz
