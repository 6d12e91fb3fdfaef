// What is asked of the coordinates of joints: angles, offsets, or both.
#pragma once

#include <span>
#include <string>

#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

// InputError where `metric` is an error of joints' coordinates, and no coordinate of its kind moves freely in the
// scenario: prescribed ones are not judged. `asked` is the word after --metric.
void require_coordinates(const Scenario& scenario, const std::string& metric, const std::string& asked);

// The unit of error-joint-coordinate of all joints, as the rows have it: "rad", "m", or "rad, m". Empty: another
// metric, or no such row.
std::string joint_unit(std::span<const Row> rows, const std::string& metric);

// The coordinates that error-joint-angle or error-joint-offset leaves out, with their error in one run, as a sentence.
// Empty: another metric, or the scenario has no such coordinates.
std::string unjudged_coordinates(std::span<const Row> rows, const std::string& metric, const std::string& method,
                                 std::int64_t steps);

// The same of all runs of a scenario, as a note: from which error to which. Empty: as above.
std::string unjudged_note(std::span<const Row> rows, const std::string& metric, const std::string& scenario);

}  // namespace atwood
