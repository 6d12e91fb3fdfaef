// The audit's findings as words. Private to this room.
#pragma once

#include <string>
#include <vector>

#include "reports/report.hpp"

namespace atwood {

std::string audit_section(const std::vector<AuditFinding>& findings);  // Markdown; empty without findings

}  // namespace atwood
