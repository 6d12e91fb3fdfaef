// MJCF files as scenes: an imported model moves as MuJoCo moves the file itself.
#include <mujoco/mujoco.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>

#include "mechanism_scenes.hpp"
#include "mujoco/import.hpp"
#include "mujoco/mujoco.hpp"
#include "scene/files.hpp"

namespace atwood::test {
namespace {

std::string written(const std::string& name, const std::string& xml) {
  const auto path = std::filesystem::temp_directory_path() / (name + ".xml");
  std::ofstream(path) << xml;
  return path.string();
}

// Degrees, defaults, offset inertial frames, a frame without mass, a ref, a fixed body, a loop that is closed at qpos0.
const char* const kModel = R"(<mujoco model="bench">
<option gravity="0.3 0 -9.81" integrator="RK4" timestep="0.0005" solver="Newton" tolerance="0"/>
<default><joint damping="0.02"/><default class="stiff"><joint stiffness="1.5" springref="20" damping="0.1"/></default></default>
<worldbody>
  <geom name="floor" type="plane" size="1 1 .1" contype="0" conaffinity="0"/>
  <body name="stand" pos="0 0 1.5" euler="0 20 0">
    <inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>
    <body name="upper" pos="0.1 0 0" euler="10 0 30">
      <joint name="shoulder" type="hinge" axis="0.2 1 0.1" pos="0 0 0.3" ref="15"/>
      <inertial pos="0.05 -0.02 -0.1" quat="0.9 0.1 0.3 -0.2" mass="1.3" diaginertia="0.05 0.06 0.07"/>
      <body name="bracket" pos="0 0.1 -0.3" euler="0 0 45">
        <body name="lower" pos="0 0 -0.1" euler="40 0 0">
          <joint name="rail" type="slide" axis="0 0.3 1" class="stiff" springref="0.1" ref="0.05"/>
          <inertial pos="0 0 -0.2" mass="0.9" fullinertia="0.03 0.04 0.02 0.001 0.002 -0.003"/>
          <body name="plate" pos="0.1 0 -0.3"><inertial pos="0.02 0 0" mass="0.2" diaginertia="0.001 0.001 0.002"/></body>
          <body name="hand" pos="0 0.1 -0.4" euler="0 30 0">
            <joint name="wrist" type="ball" pos="0 0 0.05"/>
            <inertial pos="0 0.03 -0.1" mass="0.5" diaginertia="0.01 0.012 0.008"/>
          </body>
        </body>
      </body>
    </body>
    <body name="cross" pos="-0.5 0 0">
      <joint name="first" type="hinge" axis="1 0 0"/><joint name="second" type="hinge" axis="0 1 0" class="stiff"/>
      <inertial pos="0 0 -0.3" mass="0.7" diaginertia="0.02 0.03 0.01"/>
    </body>
    <body name="piston" pos="0.5 0 0">
      <joint name="slip" type="slide" axis="0 1 0"/><joint name="spin" type="hinge" axis="0 1 0"/>
      <inertial pos="0.1 0 -0.3" mass="0.7" diaginertia="0.02 0.03 0.01"/>
    </body>
  </body>
  <body name="drone" pos="2 1 3" euler="5 6 7">
    <freejoint/><inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.2 0.15"/>
  </body>
</worldbody>
</mujoco>)";

Scene scene_of(const std::string& toml, const std::string& name) {
  return read_scenario_text(toml, name + ".toml", std::filesystem::temp_directory_path().string()).scene;
}

}  // namespace

TEST_CASE("an imported model moves as the file does") {
  const std::string path = written("import-bench", kModel);
  const auto imported = mujoco::import_model(path);
  INFO((imported ? "" : imported.fault().reason));
  REQUIRE(imported);
  CHECK_THAT(imported->toml, Catch::Contains("2 inertias about turned axes"));
  INFO(imported->toml);
  const Scene scene = scene_of(imported->toml, "import-bench");
  const Run found = run(mujoco_engine(), method(mujoco_engine(), "rk4"), scene, Plan{0.5, 1000, 1});
  INFO(found.outcome.reason);
  REQUIRE(found.outcome.status == Status::ok);

  char error[1000] = "";
  mjModel* model = mj_loadXML(path.c_str(), nullptr, error, sizeof error);
  mjData* data = mj_makeData(model);
  for (int n = 0; n < 1000; ++n) mj_step(model, data);
  mj_forward(model, data);
  int compared = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const int id = mj_name2id(model, mjOBJ_BODY, scene.bodies[i].name.c_str());
    REQUIRE(id > 0);
    INFO(scene.bodies[i].name);
    const Pose pose = pose_of(found.samples.back(), static_cast<int>(i));
    CHECK((pose.p - V3(data->xipos[3 * id], data->xipos[3 * id + 1], data->xipos[3 * id + 2])).norm() < 1e-9);
    const Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> r(data->xmat + 9 * id);
    CHECK((pose.r - r).cwiseAbs().maxCoeff() < 1e-9);
    ++compared;
  }
  CHECK(compared ==
        7);  // upper, lower, plate, hand, cross, piston, drone; the stand is the world, the bracket has no mass
  mj_deleteData(data);
  mj_deleteModel(model);
}

TEST_CASE("what is not taken is said, in the file and beside it") {
  const std::string path = written("import-notes", R"(<mujoco><worldbody><body name="arm">
    <joint name="a" type="hinge" armature="0.1" frictionloss="0.2" limited="true" range="-10 10"/>
    <geom type="sphere" size=".1"/></body></worldbody><actuator><motor joint="a"/></actuator></mujoco>)");
  const auto imported = mujoco::import_model(path);
  REQUIRE(imported);
  for (const char* word : {"the armature of the joint a\n", "the frictionloss of the joint a\n", "1 geoms",
                           "1 actuators: actuator0\n", "soft limits"})
    CHECK_THAT(imported->toml, Catch::Contains(word));
  CHECK(imported->notes.size() == 5);
  const Scene scene = scene_of(imported->toml, "import-notes");
  REQUIRE(scene.joints[0].limits);
  CHECK(scene.joints[0].limits->upper == Approx(10 * M_PI / 180).epsilon(1e-15));
}

namespace {

const char* const kArm = R"(<body name="arm"><joint name="a" type="hinge" limited="true" range="-10 10" stiffness="2"
    frictionloss="1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>)";

// The notes on a model of these elements.
std::vector<std::string> notes_on(const std::string& name, const std::string& inside) {
  const auto imported = mujoco::import_model(written(name, "<mujoco>" + inside + "</mujoco>"));
  INFO((imported ? "" : imported.fault().reason));
  REQUIRE(imported);
  return imported->notes;
}

}  // namespace

TEST_CASE("the forces of a free joint are named, also those of the defaults") {
  const std::string body = R"(<worldbody><body><joint name="f" type="free" STATED/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>)";
  const auto with = [&](const std::string& stated) {
    return std::string(body).replace(body.find("STATED"), 6, stated);
  };
  const std::string forces = R"( stiffness="3" damping="2" armature="0.1" frictionloss="0.3")";
  const std::vector<std::string> expected{"the stiffness of the free joint f", "the damping of the free joint f",
                                          "the armature of the free joint f", "the frictionloss of the free joint f"};
  CHECK(notes_on("import-free", with(forces)) == expected);
  CHECK(notes_on("import-free-default", "<default><joint" + forces + "/></default>" + with("")) == expected);
  CHECK(notes_on("import-freejoint", with("")).empty());
}

TEST_CASE("what flags disable is not in the scene, and each is named") {
  const std::string world = std::string("<worldbody>") + kArm + "</worldbody>" +
                            R"(<equality><connect name="pin" body1="arm" anchor="0 0 0"/></equality>)";
  const auto with = [&](const std::string& flags) {
    return mujoco::import_model(
        written("import-flags", "<mujoco><option><flag " + flags + "/></option>" + world + "</mujoco>"));
  };
  const auto weightless = with(R"(gravity="disable")");
  REQUIRE(weightless);
  CHECK(scene_of(weightless->toml, "import-flags").gravity_m_per_s2 == Real3{});
  CHECK(weightless->notes == std::vector<std::string>{"the frictionloss of the joint a",
                                                      "MuJoCo's soft limits became stops without restitution",
                                                      "MuJoCo's soft equality constraints became joints that close "
                                                      "loops exactly"});
  const auto open = with(R"(equality="disable" limit="disable" passive="disable" frictionloss="disable")");
  REQUIRE(open);
  const Scene scene = scene_of(open->toml, "import-flags");
  REQUIRE(scene.joints.size() == 1);
  CHECK_FALSE(scene.joints[0].limits);
  CHECK(scene.joint_forces.empty());
  CHECK(open->notes == std::vector<std::string>{"the flag equality=\"disable\": equality constraints close no loops",
                                                "the flag frictionloss=\"disable\"",
                                                "the flag limit=\"disable\": joints have no stops",
                                                "the flag passive=\"disable\": joints have no springs and dampers"});
  const auto bare = with(R"(constraint="disable" energy="enable")");
  REQUIRE(bare);
  CHECK_FALSE(scene_of(bare->toml, "import-flags").joints[0].limits);
  CHECK(bare->notes.size() == 2);
  CHECK(bare->notes[1] == "the flag energy=\"enable\"");
}

TEST_CASE("notes are of what was made, and name each element") {
  const std::string ball = R"(<worldbody><body name="b"><joint name="x" type="ball" limited="true" range="0 50"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><site name="tip"/><site/></body></worldbody>)";
  CHECK(notes_on("import-ball", ball + R"(<equality><connect name="pin" body1="b" anchor="0 0 0" active="false"/>
    </equality>)") == std::vector<std::string>{"the range of the ball joint x: only hinges and sliders have stops",
                                               "the equality constraint pin, which is not active",
                                               "2 sites: tip, site1"});
  const std::string arm =
      std::string("<option><flag frictionloss=\"disable\" limit=\"disable\"/></option><worldbody>") + kArm +
      "</worldbody>";
  const auto notes = notes_on("import-tendon", arm + R"(<tendon><fixed name="t" stiffness="3" damping="1">
    <joint joint="a" coef="1"/></fixed><fixed><joint joint="a" coef="2"/></fixed></tendon>
    <sensor><jointpos name="angle" joint="a"/></sensor>)");
  REQUIRE(notes.size() == 5);
  CHECK(notes[0] == "the tendon t, with its stiffness, damping");
  CHECK(notes[1] == "the tendon tendon1");
  CHECK(notes[2] == "1 sensors: angle");
}

TEST_CASE("a name cannot end a note's line") {
  const auto imported = mujoco::import_model(written("import-lines", R"(<mujoco><worldbody><body><inertial pos="0 0 0"
    mass="1" diaginertia="1 1 1"/><joint armature="1" name="a&#10;id = 3"/></body></worldbody></mujoco>)"));
  REQUIRE(imported);
  CHECK(imported->notes == std::vector<std::string>{"the armature of the joint a id = 3"});
  scene_of(imported->toml, "import-lines");
}

TEST_CASE("connect and weld become joints that close loops") {
  const std::string path = written("import-loop", R"(<mujoco><compiler angle="radian"/><worldbody>
    <body name="crank" pos="0 0 0"><joint name="c" type="hinge" axis="0 1 0"/>
      <inertial pos="0.2 0 0" mass="1" diaginertia=".01 .02 .02"/>
      <body name="rod" pos="0.4 0 0" euler="0 0.3 0"><joint name="r" type="hinge" axis="0 1 0"/>
        <inertial pos="0.5 0 0" mass="1" diaginertia=".01 .02 .02"/></body></body>
    <body name="rocker" pos="1 0 -1"><joint name="k" type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0.4" mass="1" diaginertia=".02 .02 .01"/></body>
    <body name="lid" pos="0 3 0"><freejoint/><inertial pos="0 0.1 0" mass="1" diaginertia=".02 .02 .01"/></body>
    </worldbody><equality><connect name="pin" body1="rod" body2="rocker" anchor="0.9 0 0"/>
    <weld name="seat" body1="lid"/></equality></mujoco>)");
  const auto imported = mujoco::import_model(path);
  REQUIRE(imported);
  INFO(imported->toml);
  const Scene scene = scene_of(imported->toml, "import-loop");
  REQUIRE(scene.joints.size() == 5);
  const auto find = [&](const std::string& name) {
    for (const Joint& joint : scene.joints)
      if (joint.name == name) return joint;
    return Joint{};
  };
  CHECK(find("pin").closes_loop);
  CHECK(find("pin").kind == JointKind::ball);
  CHECK(find("pin").anchors_body_m[0][0] ==
        Approx(0.4));  // 0.9 from the rod's frame, 0.5 of which is its centre of mass
  CHECK(find("seat").kind == JointKind::fixed);
  CHECK(find("seat").parent == -1);
  const Run result = run(mujoco_engine(), method(mujoco_engine(), "stiff"), scene, Plan{0.2, 400, 4});
  INFO(result.outcome.reason);
  REQUIRE(result.outcome.status == Status::ok);
  CHECK(std::abs(result.p(3, 2)) < 1e-3);  // the lid's seat holds
}

TEST_CASE("models that are no scene are refused with a reason") {
  const auto reason = [](const std::string& name, const std::string& inside) {
    const auto imported = mujoco::import_model(written(name, "<mujoco>" + inside + "</mujoco>"));
    return imported ? std::string() : imported.fault().reason;
  };
  const std::string inertial = R"(<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>)";
  CHECK_THAT(reason("import-planar", "<worldbody><body name=\"b\">" + inertial +
                                         R"(<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
                                            <joint type="hinge" axis="0 0 1"/></body></worldbody>)"),
             Catch::Contains("3 joints"));
  CHECK_THAT(reason("import-coupled", "<worldbody><body name=\"b\">" + inertial +
                                          R"(<joint name="j" axis="1 0 0"/></body></worldbody>
                                             <equality><joint joint1="j"/></equality>)"),
             Catch::Contains("couples joints"));
  CHECK_THAT(reason("import-broken", "<worldbody><bodies/></worldbody>"), Catch::Contains("MuJoCo's compiler says"));
  CHECK_THAT(reason("import-empty", ""), Catch::Contains("no body that moves"));
  CHECK_THAT(reason("import-still", "<worldbody><body>" + inertial + "</body></worldbody>"),
             Catch::Contains("no body that moves"));
  CHECK_THAT(mujoco::import_model("/nowhere/model.xml").fault().reason, Catch::Contains("no such file"));
}

TEST_CASE("numbers that are not finite are refused with their element's name") {
  struct Bad {
    const char *option, *body, *joint, *inertial, *words;
  };
  const char* const inertial = R"(pos="0 0 0" mass="1" diaginertia="1 1 1")";
  for (const Bad& bad :
       {Bad{"gravity=\"0 0 -inf\"", "", "", inertial, "the gravity of <option> is -inf"},
        Bad{"", "pos=\"inf 0 0\"", "", inertial, "the position of the body `b` is inf"},
        Bad{"", "euler=\"0 nan 0\"", "", inertial, "the orientation of the body `b` is nan"},
        Bad{"", "", "", R"(pos="0 inf 0" mass="1" diaginertia="1 1 1")", "the centre of mass of the body `b`"},
        Bad{"", "", "", R"(pos="0 0 0" mass="inf" diaginertia="1 1 1")", "the mass of the body `b` is inf"},
        Bad{"", "", "", R"(pos="0 0 0" mass="1" diaginertia="inf inf inf")", "the inertia of the body `b`"},
        Bad{"", "", "", R"(pos="0 0 0" euler="nan 0 0" mass="1" diaginertia="1 1 1")", "XML contains a 'NaN'"},
        Bad{"", "", "axis=\"nan 0 0\"", inertial, "the axis of the joint `j` is nan"},
        Bad{"", "", "pos=\"0 inf 0\"", inertial, "the position of the joint `j` is inf"},
        Bad{"", "", "limited=\"true\" range=\"-inf 1\"", inertial, "the range of the joint `j` is -inf"},
        Bad{"", "", "ref=\"nan\"", inertial, "the ref of the joint `j` is nan"},
        Bad{"", "", "springref=\"inf\"", inertial, "the springref of the joint `j` is inf"},
        Bad{"", "", "stiffness=\"nan\"", inertial, "the stiffness of the joint `j` is nan"},
        Bad{"", "", "damping=\"inf\"", inertial, "the damping of the joint `j` is inf"},
        Bad{"", "", "armature=\"nan\"", inertial, "the armature of the joint `j` is nan"},
        Bad{"", "", "frictionloss=\"nan\"", inertial, "the frictionloss of the joint `j` is nan"}}) {
    INFO(bad.words);
    const auto imported = mujoco::import_model(
        written("import-finite", std::string("<mujoco><option ") + bad.option + "/><worldbody><body name=\"b\" " +
                                     bad.body + "><joint name=\"j\" " + bad.joint + "/><inertial " + bad.inertial +
                                     "/></body></worldbody></mujoco>"));
    REQUIRE_FALSE(imported);
    CHECK_THAT(imported.fault().reason, Catch::Contains(bad.words));
  }
}

}  // namespace atwood::test
