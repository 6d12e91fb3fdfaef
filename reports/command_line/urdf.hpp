// A scene from a URDF file (Unified Robot Description Format, wiki.ros.org/urdf/XML).
//
// Taken: links with their inertials; joints revolute (limits as stops), continuous, prismatic, fixed, floating;
// origins, axes, damping. A body's axes are those of its link. A link without an inertial that a fixed joint holds is a
// part of its parent; the root link, and what fixed joints hold to it, is the world. Everything else is refused or
// named.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace atwood {

struct ImportedScene {
  std::string toml;                // a scenario file, with what is not taken in its first comment
  std::vector<std::string> notes;  // what is not taken or changed, in sentences
};

// Throws InputError with line and reason: no XML, no <robot>, links and joints that make no tree, a moving link without
// mass, joints planar, mimicked or of an unknown type. `name` stands for the file.
ImportedScene import_urdf(std::string_view text, const std::string& name);

}  // namespace atwood
