// Writes the synthetic report for the browser test: write_synthetic_report OUT.html [SCENARIOS METHODS RUNGS SAMPLES]
#include <cmath>
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
  atwood::ReportData data = atwood::synthetic_report(size);
  data.dominance = atwood::find_dominance(data.rows);
  // A body on a quarter of a circle that turns with it.
  atwood::TruthPath path{data.scenarios.front().id, 1.0, {}};
  data.scenarios.front().scene.bodies.resize(1);
  data.scenarios.front().scene.bodies[0].shape = atwood::Box{{0.1, 0.2, 0.3}};
  for (int k = 0; k <= 8; ++k) {
    const float angle = 0.196f * static_cast<float>(k);
    path.samples.push_back({{std::cos(angle), std::sin(angle), 0, std::cos(angle / 2), 0, 0, std::sin(angle / 2)}});
  }
  data.paths = {path};
  const std::string html = atwood::render_html(data);
  atwood::write_file(argv[1], html);
  std::cout << data.rows.size() << " rows, " << data.series.size() << " series, " << html.size() << " bytes\n";
}
