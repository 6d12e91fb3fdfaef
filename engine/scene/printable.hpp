// Conversion of text from outside (titles, names, file names, messages of engines) for terminals and tables.
#pragma once

#include <string>
#include <string_view>

namespace atwood {

// Printable UTF-8 on one line: lines joined by " | ", tabs turned into spaces, escape sequences and control characters
// dropped, bytes that are no UTF-8 replaced by U+FFFD. Characters that change the direction of writing are dropped
// because they change how the following text is read.
std::string printable(std::string_view text);
// The same line by line: line breaks stay.
std::string printable_lines(std::string_view text);

// Whether printable_lines leaves the text unchanged, except for tabs.
bool is_printable(std::string_view text);

// A cell of a table that a spreadsheet would take for a formula (it begins with = + - @, a tab or a carriage return, or
// with apostrophes before one of them) with an apostrophe in front, which spreadsheets take for "this is text". And
// back. For text from outside only: numbers are not changed.
std::string guarded_cell(const std::string& text);
std::string unguarded_cell(const std::string& cell);

}  // namespace atwood
