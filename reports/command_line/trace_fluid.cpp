#include "reports/command_line/trace_fluid.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>

#include "reports/command_line/table.hpp"
#include "scene/printable.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

constexpr const char* kParticleColumns =
    "t_s,fluid,particle,px_m,py_m,pz_m,vx_m_per_s,vy_m_per_s,vz_m_per_s,density_kg_per_m3,pressure_Pa,temperature_K";
constexpr const char* kParticleBarColumns =
    ",px_m_bar,py_m_bar,pz_m_bar,vx_m_per_s_bar,vy_m_per_s_bar,vz_m_per_s_bar,density_kg_per_m3_bar,pressure_Pa_bar,"
    "temperature_K_bar,source";

void append_particle(std::string& line, const ParticleSample& p, int digits) {
  for (const Wide x : p.p_m) line += "," + format_number(x, digits);
  for (const Wide v : p.v_m_per_s) line += "," + format_number(v, digits);
  for (const Wide value : {p.density_kg_per_m3, p.pressure_Pa, p.temperature_K})
    line += "," + format_number(value, digits);
}

// Where each fluid's particles begin.
std::vector<std::size_t> first_particles(const Scene& scene) {
  std::vector<std::size_t> first{0};
  for (const Fluid& fluid : scene.fluids) first.push_back(first.back() + fluid.particles.position_m.size());
  return first;
}

// ---- VTK ---------------------------------------------------------------------------------------------------------
std::string base64(const std::string& bytes) {
  static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? digits[group >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

template <class T> void append_bytes(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));  // the machines this runs on are little endian
  bytes.append(raw, sizeof(T));
}

template <class T>
std::string data_array(const char* type, const char* name, int components, const std::vector<T>& values) {
  std::string bytes;
  append_bytes(bytes, static_cast<std::uint64_t>(values.size() * sizeof(T)));
  for (const T value : values) append_bytes(bytes, value);
  return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">{}</DataArray>\n",
                     type, name, components, base64(bytes));
}

std::string poly_data(const Scene& scene, const SampleView& sample) {
  std::vector<double> positions, velocities, densities, pressures, temperatures;
  std::vector<std::int32_t> fluids = fluid_of_particles(scene), numbers;
  std::vector<std::int64_t> connectivity, offsets;
  const std::vector<std::size_t> first = first_particles(scene);
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample& p = sample.particles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      positions.push_back(static_cast<double>(p.p_m[k]));
      velocities.push_back(static_cast<double>(p.v_m_per_s[k]));
    }
    densities.push_back(static_cast<double>(p.density_kg_per_m3));
    pressures.push_back(static_cast<double>(p.pressure_Pa));
    temperatures.push_back(static_cast<double>(p.temperature_K));
    numbers.push_back(static_cast<std::int32_t>(i - first[static_cast<std::size_t>(fluids[i])]));
    connectivity.push_back(static_cast<std::int64_t>(i));
    offsets.push_back(static_cast<std::int64_t>(i + 1));
  }
  const std::size_t count = sample.particles.size();
  return "<?xml version=\"1.0\"?>\n"
         "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n" +
         fmt::format(
             "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
             "NumberOfPolys=\"0\">\n",
             count, count) +
         "<PointData Scalars=\"pressure\" Vectors=\"velocity\">\n" + data_array("Float64", "velocity", 3, velocities) +
         data_array("Float64", "density", 1, densities) + data_array("Float64", "pressure", 1, pressures) +
         data_array("Float64", "temperature", 1, temperatures) + data_array("Int32", "fluid", 1, fluids) +
         data_array("Int32", "particle", 1, numbers) + "</PointData>\n<Points>\n" +
         data_array("Float64", "position", 3, positions) + "</Points>\n<Verts>\n" +
         data_array("Int64", "connectivity", 1, connectivity) + data_array("Int64", "offsets", 1, offsets) +
         "</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

}  // namespace

void print_particles(const Scene& scene, const SampleSeries& values, const SampleSeries* bars,
                     const std::string& source, int digits, bool as_json) {
  Table table(fmt::format("{}{}", kParticleColumns, bars ? kParticleBarColumns : ""), as_json);
  const std::vector<int> fluids = fluid_of_particles(scene);
  const std::vector<std::size_t> first = first_particles(scene);
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t i = 0; i < values[k].particles.size() && i < fluids.size(); ++i) {
      const auto fluid = static_cast<std::size_t>(fluids[i]);
      std::string line = fmt::format("{},{},{}", format_number(values[k].t_s, digits), quoted(scene.fluids[fluid].name),
                                     i - first[fluid]);
      append_particle(line, values[k].particles[i], digits);
      if (bars) {
        append_particle(line, checked((*bars)[k].particles, i), 17);
        line += "," + quoted(source);
      }
      table.row(line);
    }
}

void print_probes(const Scene& scene, const SampleSeries& values, bool as_json) {
  Table table("t_s,probe,value,unit", as_json);
  std::vector<std::vector<double>> of_probe;
  for (const FluidProbe& probe : scene.probes) of_probe.push_back(probe_values(scene, probe, values));
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t n = 0; n < scene.probes.size(); ++n) {
      const double value = of_probe[n][k];
      table.row(fmt::format("{},{},{},{}", format_double(static_cast<double>(values[k].t_s)),
                            quoted(scene.probes[n].name), std::isnan(value) ? std::string() : format_double(value),
                            probe_unit(scene.probes[n])));
    }
  for (std::size_t n = 0; n < scene.probes.size(); ++n) {
    const FluidProbe& probe = scene.probes[n];
    const std::ptrdiff_t first = probe.kind == ProbeKind::force_on_body && !of_probe[n].empty();  // that one has none
    const auto gaps =
        std::count_if(of_probe[n].begin() + first, of_probe[n].end(), [](double x) { return std::isnan(x); });
    if (gaps > 0)
      fmt::print(stderr, "atwood: warning: the probe `{}` has no value at {} of {} samples: {}\n",
                 printable(probe.name), gaps, of_probe[n].size(), probe_gap(scene, probe));
  }
}

void write_vtk(const std::string& folder, const std::string& id, const Scene& scene, const SampleSeries& values) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": " + error.message());
  std::string list =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::string name = fmt::format("{}-{:04}.vtp", id, k);
    write_file(folder + "/" + name, poly_data(scene, values[k]));
    list += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n",
                        format_double(static_cast<double>(values[k].t_s)), name);
  }
  write_file(folder + "/" + id + ".pvd", list + "</Collection>\n</VTKFile>\n");
}

}  // namespace atwood
