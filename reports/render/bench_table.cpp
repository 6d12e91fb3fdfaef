#include "bench_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "text.hpp"

namespace atwood {
namespace {

std::string cell_words(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return one_line(*text);
  const double value = std::get<double>(cell);
  if (!std::isfinite(value)) return "-";
  return std::fabs(value) >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

}  // namespace

// The first column to the left, figures to the right, notes below.
std::string render_bench_table(const BenchTable& table) {
  std::vector<std::size_t> widths;
  for (const std::string& column : table.columns) widths.push_back(display_width(column));
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i)
      widths[i] = std::max(widths[i], display_width(cell_words(row[i])));
  }
  std::string text = table.title + "\n\n";
  const auto line = [&](const auto& cells, const auto& text_of) {
    for (std::size_t i = 0; i < cells.size() && i < widths.size(); ++i) {
      const std::string word = text_of(cells[i]), room(widths[i] - std::min(widths[i], display_width(word)), ' ');
      text += i == 0 ? word + room : "  " + room + word;
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  };
  line(table.columns, [](const std::string& column) { return column; });
  for (const auto& row : table.rows) line(row, cell_words);
  if (!table.notes.empty()) text += "\n";
  for (const std::string& note : table.notes) text += note + "\n";
  return text;
}

std::string tables_section(const std::vector<BenchTable>& tables) {
  std::string out;
  for (const BenchTable& table : tables) {
    out += "## " + one_line(table.title) + "\n\n|";
    for (const std::string& column : table.columns) out += " " + escape_markdown_cell(column) + " |";
    out += "\n|";
    for (std::size_t i = 0; i < table.columns.size(); ++i) out += i == 0 ? " --- |" : " ---: |";
    out += "\n";
    for (const auto& row : table.rows) {
      out += "|";
      for (const TableCell& cell : row) out += " " + escape_markdown_cell(cell_words(cell)) + " |";
      out += "\n";
    }
    out += "\n";
    for (const std::string& note : table.notes) out += "- " + one_line(note) + "\n";
    if (!table.notes.empty()) out += "\n";
  }
  return out;
}

void append_tables(JsonText& json, const std::vector<BenchTable>& tables) {
  json.begin_array();
  for (const BenchTable& table : tables) {
    json.begin_object().member("id", table.id).member("title", table.title);
    json.key("columns").begin_array();
    for (const std::string& column : table.columns) json.text(column);
    json.end_array().key("rows").begin_array();
    for (const auto& row : table.rows) {
      json.begin_array().inline_from_here();
      for (const TableCell& cell : row) {
        if (const auto* text = std::get_if<std::string>(&cell)) json.text(*text);
        else if (std::isfinite(std::get<double>(cell))) json.number(std::get<double>(cell));
        else json.null();
      }
      json.end_array();
    }
    json.end_array().key("notes").begin_array();
    for (const std::string& note : table.notes) json.text(note);
    json.end_array().end_object();
  }
  json.end_array();
}

}  // namespace atwood
