// Meshes: neighbours of triangles, contacts of closed and open meshes, no bumps at inner edges.
#include <rapidcheck.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <numeric>

#include "collision/convex_contacts.hpp"
#include "collision/triangle_mesh.hpp"
#include "posed_shapes.hpp"

using namespace atwood;
using namespace atwood::testing;
using V = Vec3<double>;

namespace {

struct Surface {
  std::vector<Real3> points;
  std::vector<std::array<int, 3>> triangles;
};

template <class S = double> Geometry<S> geometry_of(const Surface& surface) {
  return make_geometry<S>(Mesh{"", surface.points, surface.triangles});
}
Geometry<double> shape(const Shape& s) { return make_geometry<double>(s); }

Surface box_surface(const Real3& h) {
  return {box_corners(h),
          {{0, 2, 3},
           {0, 3, 1},
           {4, 5, 7},
           {4, 7, 6},
           {0, 1, 5},
           {0, 5, 4},
           {2, 6, 7},
           {2, 7, 3},
           {0, 4, 6},
           {0, 6, 2},
           {1, 3, 7},
           {1, 7, 5}}};
}

// n x n squares of side 1 about the origin at z = 0, each cut along either diagonal, corners moved about within the
// plane.
Surface floor_surface(int n, Random& random) {
  Surface s;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double wander = i > 0 && j > 0 && i < n && j < n ? 0.3 : 0;
      s.points.push_back(
          {i - n / 2.0 + wander * uniform(random, -1, 1), j - n / 2.0 + wander * uniform(random, -1, 1), 0});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      if (random() % 2) s.triangles.insert(s.triangles.end(), {{a, b, c}, {a, c, d}});
      else s.triangles.insert(s.triangles.end(), {{a, b, d}, {b, c, d}});
    }
  return s;
}

double deepest(const std::vector<Manifold<double>>& out) {
  double least = 1e300;
  for (const auto& m : out)
    for (int i = 0; i < m.count; ++i) least = std::min(least, m.points[i].gap);
  return least;
}
std::vector<Manifold<double>> on_mesh(const Geometry<double>& mesh, const Transform<double>& pose_mesh,
                                      const Geometry<double>& b, const Transform<double>& pose_b, double margin = 0) {
  std::vector<Manifold<double>> out;
  mesh_contacts(mesh, pose_mesh, b, pose_b, margin, out);
  return out;
}

}  // namespace

TEST_CASE("a box's surface is closed, with six flat edges and twelve convex ones; a stair has a concave one") {
  const auto mesh = build_triangle_mesh<double>(box_surface({1, 2, 3}).points, box_surface({1, 2, 3}).triangles);
  CHECK(mesh.closed);
  int flat = 0, convex = 0;
  for (const auto& t : mesh.triangles)
    for (const EdgeKind kind : t.edge) flat += kind == EdgeKind::flat, convex += kind == EdgeKind::convex;
  CHECK(flat == 12);  // each seen from both sides
  CHECK(convex == 24);
  std::vector<int> given = mesh.scene_index;
  std::sort(given.begin(), given.end());
  for (int i = 0; i < 12; ++i) CHECK(given[i] == i);
  for (const V& n : mesh.point_pseudonormals) CHECK(norm(n) == Approx(1).epsilon(1e-15));
  const auto stair =
      build_triangle_mesh<double>({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 1}},
                                  {{0, 1, 2}, {0, 2, 3}, {1, 4, 6}, {1, 6, 2}, {0, 0, 1}});
  CHECK_FALSE(stair.closed);
  CHECK(stair.points.size() == 6);     // one point is given twice
  CHECK(stair.triangles.size() == 4);  // one had no area
  int concave = 0, border = 0;
  for (const auto& t : stair.triangles)
    for (const EdgeKind kind : t.edge) concave += kind == EdgeKind::concave, border += kind == EdgeKind::border;
  CHECK(concave == 2);
  CHECK(border == 6);
}

TEST_CASE("a ball anywhere over a triangulated plane touches the plane, once") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Surface surface = floor_surface(4, random);
    const Geometry<double> mesh = geometry_of(surface), ball = shape(Sphere{0.5});
    const Quat<double> world = any_turn(random);
    const V up = rotate(world, V{0, 0, 1}), shift = narrow3<double>(gauss3(random));
    for (int i = 0; i < 50; ++i) {
      V x{uniform(random, -1.9, 1.9), uniform(random, -1.9, 1.9), uniform(random, 0.05, 0.5)};
      const Real3& corner = surface.points[12];  // an inner one
      const Real3& other = surface.points[13];
      const double s = uniform(random, 0, 1);
      if (i % 3 == 1)
        x = {corner[0] + s * (other[0] - corner[0]), corner[1] + s * (other[1] - corner[1]), x.z};  // over an edge
      if (i % 3 == 2) x = {corner[0], corner[1], x.z};                                              // over a corner
      const auto m = on_mesh(mesh, placed_at<double>(shift, world), ball, placed_at<double>(shift + rotate(world, x)));
      RC_ASSERT(m.size() == 1u);
      RC_ASSERT(std::abs(m[0].points[0].gap - (x.z - 0.5)) < 1e-14);
      RC_ASSERT(norm(m[0].normal_W - up) < 1e-12);
      const V middle = shift + rotate(world, V{x.x, x.y, (x.z - 0.5) / 2});
      RC_ASSERT(norm(m[0].points[0].x_W - middle) < 1e-14);
    }
  }));
}

TEST_CASE("boxes, cylinders, capsules and hulls over a triangulated plane meet the plane") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Geometry<double> mesh = geometry_of(floor_surface(6, random)), plane = shape(Plane{{0, 0, 1}, 0});
    constexpr ShapeKind kinds[] = {ShapeKind::box, ShapeKind::cylinder, ShapeKind::capsule, ShapeKind::convex};
    const ShapeKind kind = kinds[seed % 4];
    const Geometry<double> b = shape(random_shape(kind, random));
    const bool level = random() % 2 == 0;
    const Quat<double> about_z{std::cos(uniform(random, 0, 3)), 0, 0, 1};
    const Quat<double> q = level ? normalised(about_z) : any_turn(random);
    Transform<double> pose = placed_at<double>({uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), 0}, q);
    const double lowest = separation(plane, placed_at<double>({}), b, pose).gap, depth = uniform(random, 0, 0.02);
    pose.p_W.z -= lowest + depth;
    const auto m = on_mesh(mesh, placed_at<double>({}), b, pose);
    RC_ASSERT(!m.empty());
    RC_ASSERT(std::abs(deepest(m) + depth) < 1e-13);
    for (const auto& manifold : m) {
      RC_ASSERT(norm(manifold.normal_W - V{0, 0, 1}) == 0);
      for (int i = 0; i < manifold.count; ++i) {  // on the plane, as deep as the body is there
        const auto& p = manifold.points[i];
        RC_ASSERT(std::abs(p.x_W.z - p.gap / 2) < 1e-13);
        RC_ASSERT(p.gap <= 0);
      }
    }
  }));
}

TEST_CASE("a closed mesh of a box: balls and boxes near it meet the box") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Real3 h{uniform(random, 0.2, 1), uniform(random, 0.2, 1), uniform(random, 0.2, 1)};
    const Geometry<double> mesh = geometry_of(box_surface(h)), box = shape(Box{h});
    const Transform<double> pose = placed_at<double>(narrow3<double>(gauss3(random)), any_turn(random));
    const V x = pose.p_W + 0.8 * narrow3<double>(gauss3(random));
    const Geometry<double> ball = shape(Sphere{uniform(random, 0.05, 0.6)});
    const auto s = mesh_separation(mesh, pose, ball, placed_at<double>(x)),
               t = separation(box, pose, ball, placed_at<double>(x));
    RC_ASSERT(std::abs(s.gap - t.gap) < 1e-14);
    RC_ASSERT(norm(s.normal_W - t.normal_W) < 1e-9);
    const auto m = on_mesh(mesh, pose, ball, placed_at<double>(x), 0.01);
    RC_ASSERT(m.empty() == (t.gap > 0.01));
    if (!m.empty()) {
      RC_ASSERT(std::abs(deepest(m) - t.gap) < 1e-14);
      RC_ASSERT(m.size() == 1u);  // a box touches a ball in one place
    }
    const Geometry<double> other = shape(random_shape(kConvexKinds[random() % 6], random));
    const Transform<double> place_other =
        placed_at<double>(pose.p_W + 1.5 * narrow3<double>(gauss3(random)), any_turn(random));
    const auto u = mesh_separation(mesh, pose, other, place_other), v = separation(box, pose, other, place_other);
    RC_ASSERT(std::abs(u.gap - v.gap) < 1e-13);
  }));
}

TEST_CASE("two closed meshes hit or miss as the solids do; their distance is the boxes'") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    const Real3 g{0.5, 0.4, 0.3}, h{0.6, 0.2, 0.5};
    const Transform<double> pose_a = placed_at<double>({}, any_turn(random));
    const Transform<double> pose_b =
        placed_at<double>(uniform(random, 0.3, 1) * narrow3<double>(gauss3(random)), any_turn(random));
    const auto s = separation(shape(Box{g}), pose_a, shape(Box{h}), pose_b);
    const auto m = on_mesh(geometry_of(box_surface(g)), pose_a, geometry_of(box_surface(h)), pose_b);
    if (s.gap > 1e-12) RC_ASSERT(m.empty());
    if (s.gap < -1e-12) RC_ASSERT(!m.empty());
    for (const auto& manifold : m) RC_ASSERT(std::abs(norm(manifold.normal_W) - 1) < 1e-12);
    const auto t = mesh_separation(geometry_of(box_surface(g)), pose_a, geometry_of(box_surface(h)), pose_b);
    RC_ASSERT(std::abs(s.gap - t.gap) < 1e-13);
  }));
}

namespace {

// An L of arms 2 long and 1 thick, its corner at the origin, from y = -1 to 1.
Surface angle_surface() {
  const std::array<std::array<double, 2>, 6> outline = {{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
  Surface s;
  for (const double y : {-1.0, 1.0})
    for (const auto& [x, z] : outline) s.points.push_back({x, y, z});
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    s.triangles.insert(s.triangles.end(), {{i, i + 6, j + 6}, {i, j + 6, j}});
    if (i > 0 && i < 5) s.triangles.insert(s.triangles.end(), {{0, i, i + 1}, {6, i + 7, i + 6}});
  }
  return s;
}

}  // namespace

TEST_CASE("what stands on a closed mesh meets the face it stands on, and not the sides of it") {
  const Geometry<double> angle = geometry_of(angle_surface()), block = geometry_of(box_surface({1, 1, 1}));
  REQUIRE(angle.mesh->closed);
  REQUIRE_FALSE(angle.mesh->convex);
  const std::vector<Geometry<double>> standing = {
      shape(Box{{0.25, 0.25, 0.25}}), geometry_of(box_surface({0.25, 0.25, 0.25})),
      shape(Convex{box_corners({0.25, 0.25, 0.25})}), shape(Cylinder{0.25, 0.25})};
  const auto upright = [](const std::vector<Manifold<double>>& m, double depth, double sign) {
    REQUIRE(!m.empty());
    CHECK(std::abs(deepest(m) + depth) < 1e-14);
    for (const auto& manifold : m) CHECK(norm(manifold.normal_W - V{0, 0, sign}) < 1e-12);
  };
  for (const double depth : {0x1p-4, 0x1p-20})
    for (const V& at : {V{1.625, 0.25, 0}, V{2, 0.25, 0}, V{1.75, 1, 0}, V{2, 1, 0}, V{2.125, -1.125, 0}, V{1.5, 0, 0}})
      for (const auto& body : standing) {
        const auto pose = placed_at<double>(at + V{0, 0, 1.25 - depth});
        INFO("at " << at.x << ' ' << at.y << " depth " << depth << " kind " << static_cast<int>(body.kind));
        upright(on_mesh(angle, placed_at<double>({}), body, pose), depth, 1);
        std::vector<Manifold<double>> swapped;
        find_contacts(body, pose, angle, placed_at<double>({}), 0.0, swapped);
        upright(swapped, depth, -1);
      }
  // Blocks face to face, and an L on an L.
  for (const double depth : {0.0, 0x1p-7}) {
    upright(on_mesh(block, placed_at<double>({}), block, placed_at<double>({0, 0, 2 - depth})), depth, 1);
    upright(on_mesh(block, placed_at<double>({}), block, placed_at<double>({0.5, 0.25, 2 - depth})), depth, 1);
    upright(on_mesh(block, placed_at<double>({}), angle, placed_at<double>({0.25, 0.125, 1 - depth})), depth, 1);
  }
  const Quat<double> over{0, 0, 1, 0};  // half a turn about y: its arms hang over the other's
  upright(on_mesh(angle, placed_at<double>({}), angle, placed_at<double>({2.5, 0.25, 2.9375}, over)), 0x1p-4, 1);
}

TEST_CASE("in the corner of a closed mesh both walls count") {
  const auto m = on_mesh(geometry_of(angle_surface()), placed_at<double>({}), shape(Box{{0.25, 0.25, 0.25}}),
                         placed_at<double>({1.25 - 0x1p-4, 0, 1.25 - 0x1p-5}));
  double along_x = 0, along_z = 0;
  for (const auto& manifold : m)
    for (int i = 0; i < manifold.count; ++i) {
      if (norm(manifold.normal_W - V{1, 0, 0}) < 1e-12) along_x = std::max(along_x, -manifold.points[i].gap);
      else if (norm(manifold.normal_W - V{0, 0, 1}) < 1e-12) along_z = std::max(along_z, -manifold.points[i].gap);
      else FAIL_CHECK("a normal of neither wall");
    }
  CHECK(along_x == Approx(0x1p-4).epsilon(1e-13));
  CHECK(along_z == Approx(0x1p-5).epsilon(1e-13));
}

TEST_CASE("a sheet of two triangles that pokes into a side meets it as a rectangle would") {
  const Surface square{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  for (const auto& body : {shape(Box{{0.5, 0.5, 0.5}}), geometry_of(box_surface({0.5, 0.5, 0.5}))})
    for (const double x : {-1.25, -0.75, 0.0, 0.75, 1.25})
      for (const double z : {0.0, 0.25, -0.375}) {
        INFO(x << ' ' << z);
        const auto pose = placed_at<double>({x, 1.5 - 0x1p-6, z});
        const auto s = mesh_separation(geometry_of(square), placed_at<double>({}), body, pose),
                   t = separation(shape(Rectangle{{1, 1}}), placed_at<double>({}), body, pose);
        CHECK(s.gap == Approx(t.gap).epsilon(1e-12));
        for (const auto& manifold : on_mesh(geometry_of(square), placed_at<double>({}), body, pose))
          CHECK(norm(manifold.normal_W - t.normal_W) < 1e-12);
      }
}

TEST_CASE("a box mesh sliding on a mesh floor has upright normals where it lies") {
  Random random(2);
  const Geometry<double> floor = geometry_of(floor_surface(6, random)), box = geometry_of(box_surface({0.7, 0.5, 0.3}));
  for (int i = 0; i < 50; ++i) {
    const Quat<double> q{std::cos(0.1 * i), 0, 0, std::sin(0.1 * i)};
    const auto m = on_mesh(floor, placed_at<double>({}), box, placed_at<double>({0.01 * i, -0.02 * i, 0.299}, q));
    REQUIRE(!m.empty());
    CHECK(std::abs(deepest(m) + 0.001) < 1e-13);
    for (const auto& manifold : m) CHECK(norm(manifold.normal_W - V{0, 0, 1}) < 1e-12);
  }
}

TEST_CASE("a body inside a closed mesh gets a contact that leads out; behind an open sheet there is none") {
  const Geometry<double> mesh = geometry_of(box_surface({1, 2, 3}));
  const auto ball = on_mesh(mesh, placed_at<double>({}), shape(Sphere{0.1}), placed_at<double>({0.5, 0.2, 0.3}));
  REQUIRE(ball.size() == 1);
  CHECK(ball[0].normal_W.x == 1);
  CHECK(ball[0].points[0].gap == Approx(-0.6).epsilon(1e-15));
  const auto box =
      on_mesh(mesh, placed_at<double>({}), shape(Box{{0.1, 0.1, 0.1}}), placed_at<double>({0.5, 0.2, 0.3}));
  REQUIRE(box.size() == 1);
  CHECK(box[0].normal_W.x == 1);
  CHECK(box[0].points[0].gap == Approx(-0.6).epsilon(1e-15));
  Random random(1);
  const Geometry<double> sheet = geometry_of(floor_surface(2, random));
  const auto below = on_mesh(sheet, placed_at<double>({}), shape(Sphere{0.25}), placed_at<double>({0.3, 0.2, -0.125}));
  REQUIRE(below.size() == 1);
  CHECK(below[0].normal_W.z == -1);  // a sheet pushes to the side that needs less
  CHECK(below[0].points[0].gap == -0.125);
}

TEST_CASE("out of a closed mesh that is convex leads the least way, for a mesh within a mesh too") {
  const Geometry<double> mesh = geometry_of(box_surface({1, 1, 1}));
  // The centre is nearer to +x, but the long side lies that way: 0.5 + 0.4 against 0.55 + 0.1.
  const auto box = on_mesh(mesh, placed_at<double>({}), shape(Box{{0.4, 0.1, 0.1}}), placed_at<double>({0.5, 0, 0.45}));
  REQUIRE(box.size() == 1);
  CHECK(box[0].normal_W.z == 1);
  CHECK(box[0].points[0].gap == Approx(-0.65).epsilon(1e-15));
  CHECK(box[0].count == 4);
  for (int i = 0; i < 4; ++i) CHECK(box[0].points[i].x_W.z == Approx(0.35 + 0.325).epsilon(1e-15));
  const Geometry<double> small = geometry_of(box_surface({0.25, 0.25, 0.5}));
  for (const bool swapped : {false, true}) {
    const auto pose = placed_at<double>({0.5, 0, 0.3}), origin = placed_at<double>({});
    const auto m = swapped ? on_mesh(small, pose, mesh, origin) : on_mesh(mesh, origin, small, pose);
    REQUIRE(m.size() == 1);
    CHECK(norm(m[0].normal_W - V{swapped ? -1. : 1., 0, 0}) < 1e-15);
    CHECK(m[0].points[0].gap == Approx(-0.75).epsilon(1e-15));
    const auto s = swapped ? separation(small, pose, mesh, origin) : separation(mesh, origin, small, pose);
    CHECK(s.gap == Approx(-0.75).epsilon(1e-15));
  }
  CHECK(on_mesh(mesh, placed_at<double>({}), small, placed_at<double>({3, 0, 0})).empty());
}

TEST_CASE("a mesh stands on a plane as its hull does") {
  const auto m = on_mesh(geometry_of(box_surface({1, 2, 3})), placed_at<double>({5, 6, 2.75}),
                         shape(Plane{{0, 0, 1}, 0}), placed_at<double>({}));
  REQUIRE(m.size() == 1);
  CHECK(m[0].count == 4);
  CHECK(m[0].normal_W.z == -1);
  for (int i = 0; i < 4; ++i) CHECK(m[0].points[i].gap == -0.25);
}

TEST_CASE("hostile meshes stay finite: needles, doubled triangles, three at an edge, tiny and huge") {
  CHECK(rc::check([](std::uint64_t seed) {
    Random random(seed);
    Surface s;
    const double size = std::pow(10.0, static_cast<double>(seed % 19) - 9);
    for (int i = 0; i < 12; ++i) {
      Real3 p = gauss3(random);
      for (double& x : p) x = size * (i % 3 == 0 ? std::floor(x) : x) * (i % 4 == 0 ? 1e-9 : 1);
      s.points.push_back(p);
    }
    for (int i = 0; i < 20; ++i)
      s.triangles.push_back(
          {static_cast<int>(random() % 12), static_cast<int>(random() % 12), static_cast<int>(random() % 12)});
    s.triangles.push_back(s.triangles[0]);
    s.triangles.push_back({s.triangles[1][1], s.triangles[1][0], s.triangles[1][2]});
    const Geometry<double> mesh = geometry_of(s);
    for (const ShapeKind kind : kConvexKinds) {
      const Geometry<double> b = shape(random_shape(kind, random, 100));
      const Transform<double> pose = placed_at<double>(narrow3<double>(gauss3(random)), any_turn(random));
      for (const auto& m : on_mesh(mesh, placed_at<double>({}), b, pose, 0.01)) {
        RC_ASSERT(m.count >= 1 && m.count <= 4);
        RC_ASSERT(std::abs(norm(m.normal_W) - 1) < 1e-9);
        for (int i = 0; i < m.count; ++i)
          RC_ASSERT(std::isfinite(m.points[i].gap) && std::isfinite(norm(m.points[i].x_W)));
      }
    }
    on_mesh(mesh, placed_at<double>({}), mesh, placed_at<double>({0.1 * size, 0, 0}));
  }));
}
