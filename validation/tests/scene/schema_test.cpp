// The schema knows every key of every file in the catalogue, and the keys of the contract.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "validation/tests/catalogued.hpp"

using nlohmann::json;

namespace {

bool keyword(const json& schema, const std::string& at, const char* key) {
  return schema.at(json::json_pointer(at)).contains(key);
}

const json* option(const json& options, const char* tag, const std::string& value) {
  for (const json& each : options.at("oneOf"))
    if (each.at("properties").contains(tag) && (value.empty() || each["properties"][tag].value("const", "") == value))
      return &each;
  return nullptr;
}

// The part of draft 2020-12 that the schema uses.
bool valid(const json& root, const json& schema, const json& value) {
  if (schema.contains("$ref"))
    return valid(root, root.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1))), value);
  if (schema.contains("const")) return value == schema["const"];
  if (schema.contains("enum"))
    return std::find(schema["enum"].begin(), schema["enum"].end(), value) != schema["enum"].end();
  if (schema.contains("oneOf")) {
    int fits = 0;
    for (const json& each : schema["oneOf"]) fits += valid(root, each, value);
    return fits == 1;
  }
  const std::string type = schema.value("type", "");
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "integer" || type == "number") {
    if (type == "integer" ? !value.is_number_integer() : !value.is_number()) return false;
    const double x = value.get<double>();
    return !(schema.contains("minimum") && x < schema["minimum"].get<double>()) &&
           !(schema.contains("maximum") && x > schema["maximum"].get<double>()) &&
           !(schema.contains("exclusiveMinimum") && x <= schema["exclusiveMinimum"].get<double>());
  }
  if (type == "array") {
    if (!value.is_array() || value.size() < schema.value("minItems", 0u) ||
        value.size() > schema.value("maxItems", 1u << 30))
      return false;
    for (const json& item : value)
      if (!valid(root, schema["items"], item)) return false;
    return true;
  }
  if (!value.is_object()) return false;
  for (const json& key : schema.value("required", json::array()))
    if (!value.contains(key.get<std::string>())) return false;
  for (const auto& [key, item] : value.items()) {
    const json properties = schema.value("properties", json::object());
    const json rest = schema.value("additionalProperties", json(true));
    if (properties.contains(key) ? !valid(root, properties[key], item)
        : rest.is_object()       ? !valid(root, rest, item)
                                 : rest == false)
      return false;
  }
  return true;
}

}  // namespace

TEST_CASE("the schema has the keys of the contract") {
  const json schema = json::parse(atwood::scenario_schema());
  for (const char* key : {"id", "title", "claim", "source", "tags", "run", "world", "material", "contact", "body",
                          "grid", "joint", "rope", "force", "truth", "invariant", "problem"})
    REQUIRE(keyword(schema, "/properties", key));
  for (const char* key : {"name", "mass_kg", "density_kg_per_m3", "inertia_kg_m2", "material", "shape", "position_m",
                          "orientation_wxyz", "axis_angle_deg", "euler_xyz_deg", "velocity_m_per_s",
                          "angular_velocity_body_rad_per_s", "charge_C", "fixed", "release_s"})
    REQUIRE(keyword(schema, "/properties/body/items/properties", key));
  for (const char* shape : {"sphere", "plane", "rectangle", "box", "capsule", "cylinder", "convex", "mesh", "compound"})
    REQUIRE(option(schema["$defs"]["shape"], shape, "") != nullptr);
  for (const char* kind : {"gravity", "attractor", "drag", "spring", "drive", "lorentz", "coulomb", "thruster",
                           "point-force", "rotating-frame", "potential", "joint-spring", "joint-torque"})
    REQUIRE(option(schema["$defs"]["force"], "kind", kind) != nullptr);
  for (const char* key : {"name",
                          "kind",
                          "bodies",
                          "anchors_body_m",
                          "axis_body",
                          "axes_body",
                          "frame_wxyz",
                          "angle_rad",
                          "offset_m",
                          "orientation_wxyz",
                          "rate_rad_per_s",
                          "rate_m_per_s",
                          "angular_velocity_body_rad_per_s",
                          "limits_rad",
                          "limits_m",
                          "stop_restitution",
                          "closes_loop",
                          "assemble",
                          "hold",
                          "driven_rate_rad_per_s",
                          "driven_rate_m_per_s"})
    REQUIRE(keyword(schema, "/properties/joint/items/properties", key));
  for (const char* key : {"bodies", "points_body_m", "over_m"})
    REQUIRE(keyword(schema, "/properties/rope/items/properties", key));
  const json& thruster = *option(schema["$defs"]["force"], "kind", "thruster");
  for (const char* key : {"body", "bodies", "point_body_m", "direction_body", "thrust_N", "on_s"})
    REQUIRE(thruster["properties"].contains(key));
  REQUIRE(thruster["oneOf"].size() == 2);  // one of `body` and `bodies`
  for (const json& needed : thruster["required"]) REQUIRE(needed != "body");
  const json& drag = *option(schema["$defs"]["force"], "model", "linear");
  REQUIRE((drag["properties"].contains("body") && drag["properties"].contains("bodies")));
  REQUIRE(schema["properties"]["force"]["items"]["$ref"] == "#/$defs/force");
}

TEST_CASE("resolved scenes satisfy the schema; a wrong one does not") {
  const json schema = json::parse(atwood::scenario_schema());
  for (const char* id :
       {"thrusters", "bounce-e0.8", "oscillator-driven", "arenstorf", "lorenz", "projectile-quadratic-drag",
        "pendulum-1", "door-stop", "four-bar-2", "atwood-machine-heavy-pulley", "heavy-top-fast", "flyball-governor"}) {
    INFO(id);
    const auto scenario = atwood::testing::catalogued(id);
    json value = json::parse(atwood::scenario_to_json(scenario));
    REQUIRE(valid(schema, schema["$defs"]["resolved_scenario"], value));
    value["scene"]["bodies"][0]["mas_kg"] = 1;
    REQUIRE(!valid(schema, schema["$defs"]["resolved_scenario"], value));
  }
}
