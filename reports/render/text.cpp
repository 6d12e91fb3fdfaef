#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace atwood {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

// Length of the valid UTF-8 sequence that starts at text[0]; 0 when there is none (RFC 3629: no overlong forms, no
// surrogates, at most U+10FFFF).
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if (first == 0xE0 && byte(1) < 0xA0) return 0;
  if (first == 0xED && byte(1) > 0x9F) return 0;
  if (first == 0xF0 && byte(1) < 0x90) return 0;
  if (first == 0xF4 && byte(1) > 0x8F) return 0;
  return length;
}

bool is_control(std::string_view sequence) {
  const auto first = static_cast<unsigned char>(sequence[0]);
  if (sequence.size() == 1) return (first < 0x20 && first != '\n' && first != '\t') || first == 0x7F;
  if (sequence.size() == 2 && first == 0xC2) return static_cast<unsigned char>(sequence[1]) < 0xA0;  // C1
  return sequence == "\xEF\xBF\xBE" || sequence == "\xEF\xBF\xBF";  // U+FFFE, U+FFFF: no characters of XML
}

}  // namespace

std::string clean_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const std::string_view sequence = text.substr(0, std::max<std::size_t>(length, 1));
    result += length == 0 || is_control(sequence) ? kReplacement : sequence;
    text.remove_prefix(sequence.size());
  }
  return result;
}

std::string one_line(std::string_view text) {
  std::string result = clean_text(text);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return result;
}

std::string escape_html(std::string_view text) {
  std::string result;
  for (const char c : clean_text(text)) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      case '\'': result += "&#39;"; break;
      default: result += c;
    }
  }
  return result;
}

std::string escape_markdown_cell(std::string_view text) {
  std::string result;
  for (const char c : one_line(text)) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '|':
      case '\\':
      case '`':
      case '*':
      case '_':
      case '[':
      case ']':
      case '~':
      case '!':
      case '#': result += '\\'; [[fallthrough]];
      default: result += c;
    }
  }
  return result;
}

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string fit(std::string_view text, std::size_t width) {
  if (display_width(text) <= width) return std::string(text);
  const std::size_t kept = width > 3 ? width - 3 : 0;
  std::size_t bytes = 0, points = 0;
  while (bytes < text.size()) {
    const bool starts = (static_cast<unsigned char>(text[bytes]) & 0xC0) != 0x80;
    if (starts && points++ == kept) break;
    ++bytes;
  }
  return std::string(text.substr(0, bytes)) + std::string(std::min<std::size_t>(width, 3), '.');
}

std::string figure(double value, int digits) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return fmt::format("{:.{}g}", value, digits);
}

std::string time_words(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  const double ns = seconds * 1e9;
  if (ns < 999.5) return fmt::format("{:.3g} ns", ns);
  if (ns < 999.5e3) return fmt::format("{:.3g} us", ns / 1e3);
  if (ns < 999.5e6) return fmt::format("{:.3g} ms", ns / 1e6);
  return fmt::format("{:.3g} s", seconds);
}

std::string cost_words(double cost, Cost kind) {
  if (kind == Cost::seconds) return time_words(cost);
  return std::isfinite(cost) ? fmt::format("{:.0f}", cost) : "-";
}

std::string norm_words(const std::string& metric) {
  const std::string words = metric.rfind("error-", 0) == 0 ? metric.substr(6) : metric;
  for (const auto& [end, meaning] :
       {std::pair{"-max", ", largest over the run"}, {"-end", ", at the end"}, {"-rms", ", root mean square"}}) {
    const std::size_t at = words.rfind(end);
    if (at != std::string::npos && at + 4 == words.size()) return words.substr(0, at) + meaning;
  }
  return words;
}

std::string order_words(double order, double half_width) {
  if (std::isnan(order)) return "inconclusive";
  if (half_width > 0.2) return fmt::format("inconclusive (+/- {})", figure(half_width, 2));
  if (std::abs(order) < 0.25) return "inconclusive (no convergence)";
  return fmt::format("{:.2f}", order);
}

std::string rung_words(const std::string& method, std::int64_t steps) {
  if (method_family(method) == method) return fmt::format("{} steps", steps);
  const std::size_t colon = method.find(':');
  const std::string tail = method.substr(colon + 1);
  return "tol " + tail.substr(0, tail.size() - (method_family(method).size() - colon - 4));
}

std::string spacing_words(const Resolution& at) {
  if (!at.first) return "";
  return fmt::format("dx {:.4g}{}", *at.first, at.second ? fmt::format(", c {:.4g}", *at.second) : "");
}

std::string rung_words(const std::string& method, std::int64_t steps, const Resolution& at) {
  const std::string words = rung_words(method, steps), spacing = spacing_words(at);
  return spacing.empty() ? words : words + ", " + spacing;
}

std::string allowed_words(const Verdict& verdict) {
  switch (verdict.gate.kind) {
    case Gate::Kind::within: return fmt::format("[{}, {}]", figure(verdict.allowed_low), figure(verdict.allowed_high));
    case Gate::Kind::within_claim: return "what is claimed";  // gates_of_claims() made it `within` before judging
    case Gate::Kind::min: return ">= " + figure(verdict.allowed_low);
    case Gate::Kind::max: return "<= " + figure(verdict.allowed_high);
    case Gate::Kind::max_ratio:
      return fmt::format("<= {} ({} x {})", figure(verdict.allowed_high), figure(verdict.gate.high),
                         verdict.gate.ratio_to);
  }
  return "";
}

std::string measured_words(const Verdict& verdict) {
  if (verdict.judgement == Judgement::not_run) return "-";
  const std::string value = figure(verdict.value);
  // A bar below a thousandth of the figure changes no digit worth reading.
  return std::abs(verdict.value) < 1000 * verdict.bar ? value + " +/- " + figure(verdict.bar, 2) : value;
}

std::string origin_words(const std::string& origin) {
  const std::size_t at = origin.rfind("/validation/gates/");
  return at == std::string::npos ? origin : origin.substr(at + 1);
}

JudgementCounts count(const std::vector<Verdict>& verdicts) {
  JudgementCounts counts;
  for (const Verdict& verdict : verdicts) {
    switch (verdict.judgement) {
      case Judgement::pass: ++counts.pass; break;
      case Judgement::fail: ++counts.fail; break;
      case Judgement::unverifiable: ++counts.unverifiable; break;
      case Judgement::not_run: ++counts.not_run; break;
    }
  }
  return counts;
}

std::string words(const JudgementCounts& counts) {
  const std::int64_t all = counts.pass + counts.fail + counts.unverifiable + counts.not_run;
  return fmt::format("{} {}: {} pass, {} fail, {} unverifiable, {} not run", all, all == 1 ? "gate" : "gates",
                     counts.pass, counts.fail, counts.unverifiable, counts.not_run);
}

std::vector<const Verdict*> failing_first(const std::vector<Verdict>& verdicts) {
  std::vector<const Verdict*> sorted;
  for (const Judgement wanted : {Judgement::fail, Judgement::unverifiable, Judgement::not_run, Judgement::pass}) {
    for (const Verdict& verdict : verdicts) {
      if (verdict.judgement == wanted) sorted.push_back(&verdict);
    }
  }
  return sorted;
}

}  // namespace atwood
