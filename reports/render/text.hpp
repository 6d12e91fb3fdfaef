// Text that may come from anywhere (a scene's title, an engine's last words) made safe for each kind of document.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {

// Valid UTF-8: every broken byte becomes U+FFFD. Control characters other than tab and newline become U+FFFD too, so
// that neither a terminal nor an XML reader meets one.
std::string clean_text(std::string_view text);
std::string one_line(std::string_view text);              // clean, and line breaks and tabs become spaces
std::string escape_html(std::string_view text);           // clean, for element content and quoted attributes
std::string escape_markdown_cell(std::string_view text);  // one line of a table

std::size_t display_width(std::string_view text);           // code points
std::string fit(std::string_view text, std::size_t width);  // cut with "..." to at most `width` code points

std::string figure(double value, int digits = 5);   // general format; "nan", "inf", "-inf"
std::string time_words(double seconds);             // "312 ns", "12.3 us", "1.2 ms", "3.4 s"; "-" when not finite
std::string cost_words(double cost, Cost kind);     // a time, or a count of evaluations
std::string norm_words(const std::string& metric);  // "error-position-max": "position, largest over the run"
// A fitted order with the half-width of its 95 % interval: "3.98", or why it is none. Wider than +- 0.2 it cannot
// be distinguished from the next order, and an error that stays where it is has no order; one that grows as h shrinks
// has a negative one.
std::string order_words(double order, double half_width);
std::string rung_words(const std::string& method, std::int64_t steps);  // "960 steps", "tol 1e-8"
// "640 steps, dx 0.02, c 10"; of scenes without fluids as above.
std::string rung_words(const std::string& method, std::int64_t steps, const Resolution& at);
std::string spacing_words(const Resolution& at);  // "dx 0.02, c 10"; empty: no fluid
std::string truth_words(const TruthSpec& truth);
std::string allowed_words(const Verdict& verdict);   // "[3.9, 4.2]", "<= 1e-12", ">= 2"
std::string measured_words(const Verdict& verdict);  // value, with its bar where that matters; "-" when not run

// Where a gate stands. Gates of the project are shown relative to its root.
std::string origin_words(const std::string& origin);

struct JudgementCounts {
  std::int64_t pass = 0, fail = 0, unverifiable = 0, not_run = 0;
};
JudgementCounts count(const std::vector<Verdict>& verdicts);
std::string words(const JudgementCounts& counts);  // "12 gates: 10 pass, 1 fail, 0 unverifiable, 1 not run"

// Failing first (fail, unverifiable, not run), then pass; each group in its given order.
std::vector<const Verdict*> failing_first(const std::vector<Verdict>& verdicts);

}  // namespace atwood
