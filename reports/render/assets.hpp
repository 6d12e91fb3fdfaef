// The bundled scripts and styles of the report and of the player, embedded at build time from reports/web/dist.
#pragma once

#include <string_view>

namespace atwood {

extern const std::string_view report_script;
extern const std::string_view report_style;
extern const std::string_view player_script;
extern const std::string_view player_style;

}  // namespace atwood
