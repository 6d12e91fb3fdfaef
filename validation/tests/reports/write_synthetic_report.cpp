// Writes the synthetic report for the browser test: write_synthetic_report OUT.html [SCENARIOS METHODS RUNGS SAMPLES]
#include <cstdlib>
#include <iostream>

#include "synthetic.hpp"
#include "validation/study/write_file.hpp"

int main(int argc, char** argv) {
  if (argc != 2 && argc != 6) {
    std::cerr << "usage: write_synthetic_report OUT.html [SCENARIOS METHODS RUNGS SAMPLES]\n";
    return 2;
  }
  atwood::SyntheticSize size;
  if (argc == 6) size = {std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4]), std::atoi(argv[5])};
  const atwood::ReportData data = atwood::synthetic_report(size);
  const std::string html = atwood::render_html(data);
  atwood::write_file(argv[1], html);
  std::cout << data.rows.size() << " rows, " << data.series.size() << " series, " << html.size() << " bytes\n";
}
