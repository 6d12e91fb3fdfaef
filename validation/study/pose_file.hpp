// A pose of a sweep as a scene file of its own, to be looked at and run again.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// Writes FILE.toml, and FILE.NAME.obj of each mesh beside it; makes the folder. Numbers in shortest form that reads
// back the same. Throws std::runtime_error when it cannot.
void write_pose_file(const std::string& file, const std::string& id, const std::string& claim, const Scene& scene,
                     double t_end_s);

}  // namespace atwood
