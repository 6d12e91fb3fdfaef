// play: the truth and any number of methods in motion, as one page for a browser.
#pragma once

#include "reports/command_line/command_line.hpp"

namespace atwood {

int command_play(const Place&, const Options&);

}  // namespace atwood
