#include "scene/rope_path.hpp"

namespace atwood {

using namespace quad;

namespace {

struct Node {
  Vector center{}, axis{};
  Real radius = 0;  // 0: a point, whose axis means nothing
  std::string name;
};

std::vector<Node> nodes_of(const Rope& rope, const std::array<Vector, 2>& ends_m) {
  std::vector<Node> nodes{{ends_m[0], {}, 0, "its first end"}};
  for (std::size_t i = 0; i < rope.over.size(); ++i) {
    const Pulley& pulley = rope.over[i];
    nodes.push_back({wide(pulley.axle_m), unit(wide(pulley.axis)), pulley.radius_m, "pulley " + std::to_string(i)});
  }
  nodes.push_back({ends_m[1], {}, 0, "its last end"});
  return nodes;
}

}  // namespace

std::string rope_path(const Rope& rope, const std::array<Vector, 2>& ends_m, RopePath& out) {
  const std::vector<Node> nodes = nodes_of(rope, ends_m);
  constexpr double in_plane = 1e-9;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const Node &a = nodes[i], &b = nodes[i + 1];
    const Vector apart = b.center - a.center;
    const Real square = dot(apart, apart);
    const bool turns = a.radius > 0 || b.radius > 0;
    const Vector axis = a.radius > 0 ? a.axis : b.axis;
    Real sense = 1;  // of b's axis about a's
    if (a.radius > 0 && b.radius > 0) {
      if (norm(cross(a.axis, b.axis)) > in_plane)
        return "has " + a.name + " and " + b.name + ", whose axes are not parallel; expected one plane";
      sense = dot(a.axis, b.axis) < 0 ? -1 : 1;
    }
    if (turns && fabsq(dot(axis, apart)) > in_plane * sqrtq(square))
      return "leaves the plane of a pulley between " + a.name + " and " + b.name +
             "; expected both in the plane orthogonal to the pulley's axis (within 1e-9)";
    const Real k = (a.radius > 0 ? sense * b.radius : b.radius) - a.radius;
    if (!(square > k * k))
      return (turns ? "has the radius of a pulley between " + a.name + " and " + b.name +
                          " that reaches as far as they are apart; expected a larger distance"
                    : "has no length between " + a.name + " and " + b.name + "; expected points apart");
    const Real length = sqrtq(square - k * k);
    const Vector direction = (1 / square) * (length * apart + k * cross(apart, axis));
    out.directions.push_back(direction);
  }
  return "";
}

}  // namespace atwood
