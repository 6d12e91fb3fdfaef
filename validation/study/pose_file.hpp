// Writes a pose of a sweep as a scene file, to be looked at and run again.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// Writes FILE.toml and, for each mesh, FILE.NAME.obj; makes the folder. Numbers have the shortest form that reads back
// to the same double. Throws std::runtime_error where a file cannot be written.
void write_pose_file(const std::string& file, const std::string& id, const std::string& claim, const Scene& scene,
                     double t_end_s);

}  // namespace atwood
