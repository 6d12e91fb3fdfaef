// Errors in scenario files: each message has file, line, column, what was found and what was expected. Columns are
// counted by hand here, from 1.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "text.hpp"

using namespace scene_test;
using Catch::Contains;
using Catch::StartsWith;

namespace {

// A body whose keys start on line 9.
std::string body(const std::string& keys) { return kHead + "[[body]]\nname = \"b\"\n" + keys; }
// A force whose keys start on line 11 (kind on line 11 itself).
std::string force(const std::string& keys) { return body("mass_kg = 1\n[[force]]\n") + keys; }

void check(const std::string& text, const std::string& start, const std::string& found, const std::string& expected) {
  INFO(text);
  const std::string error = message(text);
  CHECK_THAT(error, StartsWith("t.toml:" + start + ": ") && Contains(found) && Contains("expected " + expected));
}

}  // namespace

TEST_CASE("the texts that these tests vary are right as they stand") {
  REQUIRE(message(body("mass_kg = 1\n")) == "no error");
  REQUIRE(message(force("kind = \"drag\"\nmodel = \"linear\"\nbodies = \"all\"\ncoefficient_kg_per_s = 1\n")) ==
          "no error");
}

TEST_CASE("unknown keys, with the likely one") {
  check(body("mas_kg = 1\n"), "9:1", "unknown key `mas_kg` in [[body]] `b`", "one of name, mass_kg");
  CHECK_THAT(message(body("mas_kg = 1\n")), Contains("(did you mean mass_kg?)"));
  CHECK_THAT(message(body("velocity = [0, 0, 0]\n")), Contains("(did you mean velocity_m_per_s?)"));
  CHECK_THAT(message(body("zzzzzz = 1\n")), !Contains("did you mean"));
  check("idd = 1\n" + body("mass_kg = 1\n"), "1:1", "unknown key `idd`", "one of id");
  check(body("mass_kg = 1\nshape.sphere = { radius = 1 }\n"), "10:18", "unknown key `radius`", "one of radius_m");
  check(body("mass_kg = 1\nshape.ball = { radius_m = 1 }\n"), "10:7", "unknown shape `ball`", "one of sphere");
  check(force("kind = \"drog\"\n"), "11:8", "`kind` in [[force]] is \"drog\"", "one of gravity");
  CHECK_THAT(message(force("kind = \"drog\"\n")), Contains("(did you mean drag?)"));
  check(force("kind = \"drag\"\nmodel = \"cubic\"\n"), "12:9", "`model`", "one of linear, quadratic");
  check(force("kind = \"drag\"\n"), "10:1", "missing key `model`", "one of linear, quadratic");
  check(body("mass_kg = 1\n[world]\ngravity = [0, 0, -9.8]\n"), "11:1", "unknown key `gravity`",
        "one of gravity_m_per_s2");
  check(body("mass_kg = 1\n[world]\nsimultaneous_impacts = \"both\"\n"), "11:24", "`simultaneous_impacts` in [world]",
        "one of sequential, together");
}

TEST_CASE("missing keys name the table's place") {
  check("title = \"x\"\n", "1:1", "missing key `id`", "a unique id in kebab-case");
  check("id = \"x\"\n[run]\nt_end_s = 1\nsteps = [4]\n[[body]]\nname = \"b\"\nmass_kg = 1\n", "2:1",
        "missing key `samples`", "samples");
  check(body(""), "7:1", "missing key `mass_kg` in [[body]] `b`", "a mass above 0");
  check(body("mass_kg = 1\nshape.sphere = {}\n"), "10:16", "missing key `radius_m`", "radius");
  check(kHead, "1:1", "no [[body]]", "at least one");
  check(force("kind = \"attractor\"\nbodies = \"all\"\n"), "10:1", "missing key `mu_m3_per_s2`", "G M");
  check(force("kind = \"spring\"\nbodies = [\"b\"]\nstiffness_N_per_m = 1\n"), "10:1", "missing key `anchor_m`",
        "the other end");
  check(body("mass_kg = 1\n[truth]\nkind = \"closed-form\"\n"), "11:8", "missing key `solution`", "the id");
}

TEST_CASE("numbers that are none, or that no body has") {
  check(body("mass_kg = -1\n"), "9:11", "`mass_kg` in [[body]] `b` is -1", "a number above 0");
  check(body("mass_kg = 0\n"), "9:11", "is 0", "a number above 0");
  check(body("mass_kg = nan\n"), "9:11", "is nan", "a number");
  check(body("mass_kg = inf\n"), "9:11", "is inf", "a number");
  check(body("mass_kg = \"one\"\n"), "9:11", "is \"one\"", "a number");
  check(body("mass_kg = 1\nposition_m = [0, nan, 0]\n"), "10:18", "`position_m`", "a finite number");
  check(body("mass_kg = 1\nposition_m = [0, 0]\n"), "10:14", "is a list of 2", "a list of 3 numbers");
  check(body("mass_kg = 1\nposition_m = [0, 0, -inf]\n"), "10:21", "is -inf", "a finite number");
  check(body("mass_kg = 1\nshape.sphere.radius_m = 0\n"), "10:25", "is 0", "a number above 0");
  check(body("mass_kg = 1\n[material.x]\nrestitution = 1.5\n"), "11:15", "is 1.5", "a number from 0 to 1");
  check(body("mass_kg = 1\nrelease_s = -1\n"), "10:13", "is -1", "a number of at least 0");
  check(body("mass_kg = 1\nfixed = 1\n"), "10:9", "is 1", "true or false");
}

TEST_CASE("orientations and directions that are no unit") {
  check(body("mass_kg = 1\norientation_wxyz = [1, 0, 0, 0.1]\n"), "10:20", "length 1.00498756211208",
        "a quaternion (w, x, y, z) of length 1 (a deviation up to 1e-3 is normalised)");
  REQUIRE(message(body("mass_kg = 1\norientation_wxyz = [1.0000000009, 0, 0, 0]\n")) == "no error");
  check(body("mass_kg = 1\norientation_wxyz = [1.0011, 0, 0, 0]\n"), "10:20", "length", "a quaternion");
  check(body("mass_kg = 1\norientation_wxyz = [0, 0, 0, 0]\n"), "10:20", "length 0", "a quaternion");
  check(body("mass_kg = 1\norientation_wxyz = [1e300, 1e300, 0, 0]\n"), "10:20", "length", "a quaternion");
  check(body("shape.plane.normal = [0, 0, 2]\n"), "9:22", "length 2", "a vector of length 1");
  check(force("kind = \"thruster\"\nbody = \"b\"\nthrust_N = 1\ndirection_body = [1, 1, 0]\n"), "14:18", "length 1.41",
        "a vector of length 1");
}

TEST_CASE("inertia that no body has") {
  check(body("mass_kg = 1\ninertia_kg_m2 = [1, 1, 3]\n"), "10:17", "principal moments 1, 1, 3", "none above the sum");
  check(body("mass_kg = 1\ninertia_kg_m2 = [1, 1, -1]\n"), "10:17", "principal moments -1, 1, 1", "all above 0");
  check(body("mass_kg = 1\ninertia_kg_m2 = [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]\n"), "10:17", "not symmetric",
        "a symmetric matrix");
  check(body("mass_kg = 1\ninertia_kg_m2 = [1, 1]\n"), "10:17", "a list of 2", "three principal moments");
  check(body("mass_kg = 1e300\nshape.sphere.radius_m = 1e10\n"), "7:1", "overflows", "a smaller body");
  check(body("density_kg_per_m3 = 1e300\nshape.sphere.radius_m = 1e100\n"), "7:1",
        "mass of [[body]] `b` comes out as inf", "a finite number");
  check(body("mass_kg = 1\nshape.sphere.radius_m = 1e-200\n"), "10:1", "underflows to 0", "a larger body");
  check(body("mass_kg = 1\nangular_velocity_body_rad_per_s = [0, 0, 1]\n"), "10:35", "not 0 for a point mass",
        "a shape");
  check(body("mass_kg = 1\nshape.convex.points_m = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]\n"), "10:1",
        "centroid at [0.25, 0.25, 0.25]", "it at the origin");
  check(body("mass_kg = 1\nshape.convex.points_m = [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]\n"), "10:1", "no volume",
        "at least 4");
  check(body("mass_kg = 1\nshape.compound.boxes = [{ half_extents_m = [1,1,1], position_body_m = [1,0,0] }]\n"), "10:1",
        "centroid at [1, 0, 0]", "it at the origin");
}

TEST_CASE("masses given twice or from nothing; planes and fixed bodies") {
  check(body("mass_kg = 1\ndensity_kg_per_m3 = 1\nshape.sphere.radius_m = 1\n"), "10:21", "beside `mass_kg`",
        "one of the two");
  check(body("density_kg_per_m3 = 1\n"), "9:21", "without a shape", "`mass_kg`");
  check(body("density_kg_per_m3 = 1\nshape.rectangle.half_extents_m = [1, 1]\n"), "10:1", "has no volume", "`mass_kg`");
  check(body("fixed = false\nshape.plane.normal = [0, 0, 1]\n"), "9:9", "false for a plane", "true");
  check(body("position_m = [0, 0, 1]\nshape.plane.normal = [0, 0, 1]\n"), "9:14", "given for a plane",
        "`normal` and `offset_m`");
  check(body("fixed = true\nvelocity_m_per_s = [1, 0, 0]\n"), "10:20", "not 0 for a fixed body", "0");
  check(body("fixed = true\n[[body]]\nname = \"c\"\nmass_kg = 1\n[[force]]\nkind = \"gravity\"\nbodies = [\"b\", "
             "\"c\"]\n"),
        "15:10", "fixed body `b`", "free bodies");
}

TEST_CASE("names: unknown, used twice, malformed") {
  check(body("mass_kg = 1\n[[body]]\nname = \"b\"\nmass_kg = 1\n"), "11:8", "two [[body]] tables have the name `b`",
        "unique names");
  check(body("mass_kg = 1\nmaterial = \"wod\"\n[material.wood]\n"), "10:12", "`material` in [[body]] `b` is \"wod\"",
        "the name of a material");
  CHECK_THAT(message(body("mass_kg = 1\nmaterial = \"wod\"\n[material.wood]\n")), Contains("(did you mean wood?)"));
  check(force("kind = \"coulomb\"\nconstant_N_m2_per_C2 = 1\nbodies = [\"b\", \"c\"]\n"), "13:16", "is \"c\"",
        "the name of a body (b)");
  check(force("kind = \"coulomb\"\nconstant_N_m2_per_C2 = 1\nbodies = [\"b\", \"b\"]\n"), "13:16", "is \"b\"",
        "each body once");
  check(force("kind = \"coulomb\"\nconstant_N_m2_per_C2 = 1\nbodies = []\n"), "13:10", "a list of 0",
        "\"all\" or a list");
  check(force("kind = \"point-force\"\nforce_N = [1, 0, 0]\nbody = \"ship\"\n"), "13:8", "is \"ship\"",
        "the name of a body (b)");
  check(kHead + "[[body]]\nname = \"a,b\"\nmass_kg = 1\n", "8:8", "a,b", "a name of 1 to 100 characters");
  check("id = \"My Test\"\n" + kHead.substr(12) + "[[body]]\nname = \"b\"\nmass_kg = 1\n", "1:6", "is \"My Test\"",
        "a kebab-case id");
  check(body("mass_kg = 1\n[[contact]]\nbetween = [\"default\", \"steel\"]\n"), "11:23", "is \"steel\"",
        "the name of a material");
  const std::string contact = "mass_kg = 1\n[[contact]]\nbetween = [\"default\", \"default\"]\n";
  check(body(contact + "contact_law = \"linear\"\n"), "12:15", "missing key `stiffness_N_per_m`",
        "it with the contact law linear");
  check(body(contact + "contact_law = \"hertz\"\npull = true\n"), "13:8", "`pull` in [[contact]]",
        "it with `linear` only");
  check(body(contact + "modulus_Pa = 1\n"), "12:14", "beside the contact law rigid", "it with `hertz` only");
  check(body("mass_kg = 1\n[[contact]]\nbetween = [\"default\", \"default\"]\n[[contact]]\nbetween = [\"default\", "
             "\"default\"]\n"),
        "13:11", "a second time", "each pair once");
  check(body("mass_kg = 1\n[[invariant]]\nquantity = \"enrgy\"\n"), "11:12", "is \"enrgy\"", "one of energy");
  check(body("mass_kg = 1\n[[grid]]\nbody = \"ball\"\ncounts = [1, 1, 1]\nspacing_m = [1, 1, 1]\n"), "11:8",
        "is \"ball\"", "the name of a [[body]]");
}

TEST_CASE("the run") {
  const auto run = [](const std::string& keys) {
    return "id = \"t\"\n[run]\n" + keys + "[[body]]\nname = \"b\"\nmass_kg = 1\n";
  };
  check(run("t_end_s = 1\nsteps = [64, 100]\nsamples = 64\n"), "5:11", "does not divide the step count 100",
        "a divisor");
  check(run("t_end_s = 1\nsteps = [0]\nsamples = 1\n"), "4:10", "is 0", "a whole number from 1");
  check(run("t_end_s = 1\nsteps = [-64]\nsamples = 1\n"), "4:10", "is -64", "a whole number from 1");
  check(run("t_end_s = 1\nsteps = [64.5]\nsamples = 1\n"), "4:10", "is 64.5", "a whole number");
  check(run("t_end_s = 1\nsteps = []\nsamples = 1\n"), "4:9", "empty list", "at least one");
  check(run("t_end_s = 1\nsteps = [128, 64]\nsamples = 1\n"), "4:9", "64 after 128", "growing");
  const std::string frames = "t_end_s = 1\nsteps = [2, 4]\nsamples = 1\nframe_ends_s = ";
  CHECK(message(run(frames + "[0.4, 1]\n")) == "no error");
  check(run(frames + "[0.4, 0.4]\n"), "6:16", "0.4 after 0.4", "growing times");
  check(run(frames + "[0.4, 0.9]\n"), "6:16", "ends at 0.9", "t_end_s, 1");
  check(run(frames + "[0.2, 0.4, 1]\n"), "4:9", "has 2", "a multiple of the 3 frames");
  check(run("t_end_s = 1\nsteps = [2]\nsamples = 2\nframe_ends_s = [0.4, 1]\n"), "5:11", "is 2",
        "1 with recorded frames");
  check(run("t_end_s = 1\nsteps = { from = 1, rungs = 60 }\nsamples = 1\n"), "4:9", "grows past", "fewer rungs");
  check(run("t_end_s = 1\nsteps = { from = 1, rungs = 2, ratio = 1 }\nsamples = 1\n"), "4:40", "is 1",
        "a number above 1");
  check(run("t_end_s = 1\nsteps = { from = 1, rung = 2 }\nsamples = 1\n"), "4:21", "unknown key `rung`",
        "one of from, rungs, ratio");
  check(run("t_end_s = 0\nsteps = [1]\nsamples = 1\n"), "3:11", "is 0", "a number above 0");
  check(run("t_end_s = 1\nsteps = [1]\nsamples = 0\n"), "5:11", "is 0", "a whole number");
}

TEST_CASE("inconsistent parts of forces") {
  const std::string thruster = "kind = \"thruster\"\nbody = \"b\"\nthrust_N = 1\ndirection_body = [1, 0, 0]\n";
  check(force(thruster + "on_s = [[2, 1]]\n"), "15:9", "the interval [2, 1]", "[from, to] with from < to");
  check(force(thruster + "on_s = [[0, 2], [1, 3]]\n"), "15:8", "starts at 1", "intervals in order");
  check(force(thruster + "on_s = [0, 2]\n"), "15:9", "is 0", "a list of 2 numbers");
  check(force("kind = \"potential\"\nbodies = \"all\"\nname = \"morse\"\n"), "13:8", "is \"morse\"",
        "one of henon-heiles");
  check(body("mass_kg = 1\nshape.sphere.radius_m = 1\n[[force]]\nkind = \"rotating-frame\"\nangular_velocity_rad_per_s "
             "= [0, 0, 1]\n"),
        "11:1", "the body `b`, which rotates", "point masses only");
  check(body("mass_kg = 1\n[truth]\nkind = \"extended\"\nsolution = \"kepler\"\n"), "12:12", "beside kind \"extended\"",
        "it with \"closed-form\" and truths of fluids only");
  check(body("mass_kg = 1\n[truth]\nkind = \"values\"\nfile = \"none.csv\"\n"), "12:8", "is \"none.csv\"",
        "a file that exists");
  check(body("mass_kg = 1\n[truth]\nkind = \"values\"\nfile = \"../x.csv\"\n"), "12:8", "is \"../x.csv\"",
        "a file inside the scene's folder");
  check("problem = \"lorenz\"\n" + body("mass_kg = 1\n"), "8:1", "found `body` beside `problem`",
        "neither world nor bodies");
}

TEST_CASE("hostile files end in words, quickly") {
  const std::string grid = "mass_kg = 1\n[[grid]]\nbody = \"b\"\nspacing_m = [1, 1, 1]\ncounts = ";
  check(body(grid + "[100000, 100000, 100000]\n"), "13:10", "more than 200000 bodies", "fewer");
  check(body(grid + "[1000000000, 1, 1]\n"), "13:11", "is 1000000000", "a whole number from 1 to 200000");
  check(body(grid + "[9223372036854775808, 1, 1]\n"), "13:30", "not valid TOML", "a scenario in TOML");
  // [run] is level 1 and the first bracket, in column 5, level 2: level 33 is in column 36.
  check(kHead + "x = " + std::string(40, '[') + "0" + std::string(40, ']') + "\n", "7:36", "nesting deeper than 32",
        "a scenario");
  const std::string deep = message("x = " + std::string(100000, '[') + "\n");
  CHECK_THAT(deep, StartsWith("t.toml:1:"));
  check("id = \"t\"\nx = 1e999\n", "2:10", "1e999", "a scenario in TOML");  // the parser points behind it
}

TEST_CASE("files that are not TOML, not UTF-8 or do not exist are refused with the place") {
  // In invalid TOML the place is the parser's own: behind the last thing it could read.
  check("id = \"t\"\nsteps = [1, 2", "2:14", "not valid TOML", "a scenario in TOML");
  check("id = \"t\"\nid = \"u\"\n", "2:6", "cannot redefine", "a scenario in TOML");
  check("id = \"\xff\xfe\"\n", "1:7", "not UTF-8", "a scenario in TOML");
  check("# \xc3\xa9\nid = \"\xe9t\xe9\"\n", "2:7", "not UTF-8", "a scenario in TOML");
  check("id = 1979-05-27\n", "1:6", "a date or time", "a number, text, list or table");
  CHECK_THAT(message(""), StartsWith("t.toml:1:1: missing key `id`"));
  const auto error_of = [](const std::string& path) -> std::string {
    try {
      atwood::read_scenario(path);
    } catch (const atwood::InputError& error) {
      return error.what();
    }
    return "no error";
  };
  CHECK_THAT(error_of("/nowhere/scene.toml"),
             StartsWith("/nowhere/scene.toml: ") && Contains("No such file") && Contains("expected a scenario file"));
  CHECK_THAT(error_of("/tmp"), StartsWith("/tmp: found a directory") && Contains("expected a scenario file"));
}
