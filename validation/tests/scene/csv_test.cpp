// Tables of comma-separated values: cells, quotes, comments and line numbers.
#include "scene/csv.hpp"

#include <catch2/catch.hpp>

using namespace atwood;

namespace {

using Cells = std::vector<std::string>;

std::vector<Cells> rows_of(const std::string& text) {
  CsvReader reader(text, "t.csv");
  std::vector<Cells> rows;
  for (Cells cells; reader.next(cells);) rows.push_back(cells);
  return rows;
}

}  // namespace

TEST_CASE("cells: quotes, spaces, empty ones and line ends") {
  CHECK(rows_of("a,b\n1,2\n") == std::vector<Cells>{{"a", "b"}, {"1", "2"}});
  CHECK(rows_of("a , b\r\n 1,2 ") == std::vector<Cells>{{"a", "b"}, {"1", "2"}});
  CHECK(rows_of("my ball,\"red, big\",\"say \"\"so\"\"\"") ==
        std::vector<Cells>{{"my ball", "red, big", "say \"so\""}});
  CHECK(rows_of("\" kept \",,") == std::vector<Cells>{{" kept ", "", ""}});
  CHECK(rows_of(",\n") == std::vector<Cells>{{"", ""}});
  CHECK(rows_of("a\"b\"c") == std::vector<Cells>{{"abc"}});
  CHECK(rows_of("\"open, to the end") == std::vector<Cells>{{"open, to the end"}});
  CHECK(rows_of("").empty());
  CHECK(rows_of("\n\r\n# nothing\n").empty());
}

TEST_CASE("empty lines and comments are left out, and lines are counted from 1") {
  CsvReader reader("# source: a paper\n\nt_s,body\r\n# between\n0,ball", "t.csv");
  Cells cells;
  REQUIRE(reader.next(cells));
  CHECK(reader.line() == 3);
  CHECK(cells == Cells{"t_s", "body"});
  CHECK(reader.comments() == Cells{"# source: a paper"});
  REQUIRE(reader.next(cells));
  CHECK(reader.line() == 5);
  CHECK(cells == Cells{"0", "ball"});
  CHECK(reader.comments().size() == 2);
  CHECK_FALSE(reader.next(cells));
  CHECK(cells.empty());
}

TEST_CASE("a row of too many cells is refused with its line") {
  CHECK(rows_of(std::string(CsvReader::kMaxCells - 1, ','))[0].size() == CsvReader::kMaxCells);
  CHECK_THROWS_WITH(rows_of("a\n" + std::string(CsvReader::kMaxCells, ',')),
                    "t.csv:2:1: found more than 4096 cells; expected fewer");
}
