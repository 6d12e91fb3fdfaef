// trace of a scene with fluids: particles and probes as CSV, files for ParaView.
#pragma once

#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// t_s,fluid,particle,px_m,...,temperature_K of every sample; the particle counts from 0 in its fluid. With `bars` (as
// many samples) a column of each value's bar and the source.
void print_particles(const Scene& scene, const SampleSeries& values, const SampleSeries* bars,
                     const std::string& source, int digits, bool json);

// t_s,probe,value,unit of every sample; a probe that says nothing has an empty value.
void print_probes(const Scene& scene, const SampleSeries& values, bool json);

// FOLDER/ID.pvd and a file ID-0000.vtp a sample: VTK's XML PolyData (VTK User's Guide, 11th ed., ch. 19), the particles
// as vertices with velocity [m/s], density [kg/m^3], pressure [Pa], temperature [K], fluid and particle, in binary
// (base64, little endian, not compressed, 64-bit headers). The folder is made where it is not there. Throws
// std::runtime_error.
void write_vtk(const std::string& folder, const std::string& id, const Scene& scene, const SampleSeries& values);

}  // namespace atwood
