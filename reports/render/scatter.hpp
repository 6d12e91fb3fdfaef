// A scatter plot in characters: curves on logarithmic axes, a letter a curve. For terminals, and tests of it by eye.
#pragma once

#include <string>
#include <vector>

namespace atwood {

// Same length; points that are not positive are left out
struct ScatterCurve {
  char letter;
  std::vector<double> x, y;
};
struct Scatter {
  std::string x_label, y_label;
  std::vector<ScatterCurve> curves;  // neighbouring points are joined by dots
  int width = 80, height = 22;       // of everything: labels, axes and legend line
};
// Lines of at most `width` characters, ASCII only. A place where letters of several curves meet shows `*`.
// Nothing to draw: one line that says so.
std::string render_scatter(const Scatter& scatter);

}  // namespace atwood
