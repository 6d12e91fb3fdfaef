// Rows as CSV: the columns are a published contract. Quoting as in RFC 4180, lines end in LF, text is valid UTF-8
// without control characters (an engine's last words may hold anything). What scenes and engines wrote begins with an
// apostrophe where it would begin with = + - @: a spreadsheet would compute it.
#include <string_view>

#include "protocol/sample.hpp"
#include "reports/report.hpp"
#include "scene/printable.hpp"
#include "text.hpp"

namespace atwood {
namespace {

std::string field(const std::string& raw) {
  const std::string text = clean_text(raw);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

// Of text that a scene or an engine wrote: no spreadsheet takes it for a formula.
std::string foreign(const std::string& raw) { return field(guarded_cell(raw)); }

}  // namespace

std::string render_csv(const std::vector<Row>& rows) {
  std::string text =
      "scenario,method,steps,h_s,body,t_s,metric,unit,value,truth_bar,status,reason,settings_hash,engine_version,"
      "commit,compiler,flags,cpu,run_id,spacing_m,sound_speed_m_per_s\n";
  text.reserve(rows.size() * 240);
  for (const Row& row : rows) {
    const Provenance& from = *row.provenance;
    for (const std::string& column :
         {foreign(row.scenario), foreign(row.method), std::to_string(row.steps), format_double(row.h_s),
          foreign(row.body), row.t_s ? format_double(*row.t_s) : std::string(), field(row.metric), field(row.unit),
          format_double(row.value), format_double(row.truth_bar), to_string(row.status), foreign(row.reason),
          field(row.settings_hash), foreign(from.engine_version), field(from.commit), field(from.compiler),
          field(from.flags), field(from.cpu)}) {
      text += column;
      text += ',';
    }
    text += field(from.run_id);
    for (const auto& of_fluid : {row.spacing_m, row.sound_speed_m_per_s})
      text += of_fluid ? "," + format_double(*of_fluid) : ",";
    text += '\n';
  }
  return text;
}

}  // namespace atwood
