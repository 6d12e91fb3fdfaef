// The bundled scripts and styles of the report, of the player and of the history's pages, embedded at build time from
// reports/web/dist.
#pragma once

#include <string_view>

namespace atwood {

extern const std::string_view report_script;
extern const std::string_view report_style;
extern const std::string_view player_script;
extern const std::string_view player_style;
extern const std::string_view pages_script;

}  // namespace atwood
