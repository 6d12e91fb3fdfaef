// The files that a model in MJCF names, checked by our own code before MuJoCo opens any of them.
#pragma once

#include <string>
#include <string_view>

namespace atwood {

// Throws InputError where the model of this file, or a file that it includes, is not plain XML, or names a file outside
// of the model's folder (also when links are followed), or one that is not an ordinary file, or too many of them. Files
// that are not there are left to MuJoCo's message. What is checked: every attribute that begins with `file`, looked up
// in the folders that a <compiler> names. Throws it also for a mass, a pose or another number of the mechanism that is
// not finite.
void require_files_in_folder(std::string_view text, const std::string& path);

}  // namespace atwood
