// The bundled script and style of the report, embedded at build time from reports/web/dist.
#pragma once

#include <string_view>

namespace atwood {

extern const std::string_view report_script;
extern const std::string_view report_style;

}  // namespace atwood
