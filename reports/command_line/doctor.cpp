// doctor, schema: what this installation has, and the forms of its files.
#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/study/store.hpp"

namespace atwood {
namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

std::string worker_line(const Worker& worker) {
  const std::string name = fs::path(worker.path).filename().string();
  if (worker.status != Status::ok) return fmt::format("{:<18} {}: {}", name, to_string(worker.status), worker.reason);
  std::vector<std::string> ids;
  for (const auto& info : worker.engine.methods) ids.push_back(info.id.substr(info.id.find('/') + 1));
  return fmt::format("{:<18} {} {}, {}: {}", name, worker.engine.name, worker.engine.version, worker.engine.scalar,
                     ids.empty() ? "contacts only (atwood contacts, geometry-sweep)" : join(ids, " "));
}

// doctor --check-store: what the store holds against its checksums, and nothing else.
int check_store_of(const Options& options) {
  const std::string path = options.out_dir + "/store.db";
  if (!fs::exists(path)) throw InputError(fmt::format("doctor --check-store: no store at {}", path));
  std::vector<std::string> damage;
  try {
    damage = check_store(path);
  } catch (const StoreOfAnother& error) {
    throw InputError(fmt::format("doctor --check-store: {}", printable(error.what())));
  }
  if (options.json) {
    fmt::print("{}\n", json({{"store", path}, {"sound", damage.empty()}, {"damage", damage}}).dump(2));
  } else if (damage.empty()) {
    fmt::print("{}: sound, every entry as it was written\n", path);
  } else {
    for (const auto& line : damage) fmt::print("{}\n", line);
    fmt::print(
        "{}: {} damaged; `atwood run` measures damaged cells and builds damaged indexes again; where it says that the "
        "database itself is damaged, move the file away\n",
        path, damage.size() == 1 ? "1 thing is" : fmt::format("{} things are", damage.size()));
  }
  return damage.empty() ? exit_pass : exit_internal;
}

}  // namespace

namespace {

json confinement_json(const std::vector<ConfinementLine>& lines) {
  json out = json::object();
  for (const ConfinementLine& line : lines) out[line.what] = {{"how", line.how}, {"full", line.full}};
  return out;
}

}  // namespace

int command_doctor(const Place& place, const Options& options) {
  if (options.check_store) return check_store_of(options);
  const auto workers = require_workers(place, options);
  struct statvfs disk {};
  const bool disk_known = statvfs(fs::exists(options.out_dir) ? options.out_dir.c_str() : ".", &disk) == 0;
  const double free_GiB =
      disk_known ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) / (1 << 30) : 0;
  const bool truth_here = fs::exists(place.truth_worker);
  const auto confinement = describe(kernel_means(), memory_limit_of(options));
  if (options.json) {
    json out = {{"commit", place.provenance.commit},
                {"compiler", place.provenance.compiler},
                {"flags", place.provenance.flags},
                {"cpu", place.provenance.cpu},
                {"cpu_features", place.provenance.cpu_features},
                {"libm", place.provenance.libm},
                {"truth", truth_here},
                {"free_GiB", free_GiB},
                {"confinement", confinement_json(confinement)},
                {"engines", json::array()}};
    for (const auto& w : workers) {
      out["engines"].push_back({{"path", w.path},
                                {"status", to_string(w.status)},
                                {"reason", w.reason},
                                {"name", w.engine.name},
                                {"version", w.engine.version},
                                {"scalar", w.engine.scalar},
                                {"build_id", w.build_id},
                                {"sandbox", w.confinement.sandbox}});
    }
    fmt::print("{}\n", out.dump(2));
  } else {
    const Provenance& from = place.provenance;
    fmt::print("commit    {}\ncompiler  {}\nflags     {}\ncpu       {}\nfeatures  {}\nlibm      {}\n", from.commit,
               from.compiler, from.flags, from.cpu, from.cpu_features, from.libm);
    fmt::print("disk      {:.1f} GiB free for {}\ntruth     {}\n\n", free_GiB, options.out_dir,
               truth_here ? place.truth_worker : "missing: " + place.truth_worker);
    fmt::print("Workers are confined:\n");
    for (const ConfinementLine& line : confinement) fmt::print("{:<9} {}\n", line.what, line.how);
    fmt::print("\n");
    for (const auto& worker : workers) fmt::print("{}\n", worker_line(worker));
  }
  const bool broken = std::any_of(workers.begin(), workers.end(), [](const Worker& w) {
    return w.status != Status::ok && w.status != Status::not_built;
  });
  return broken || !truth_here ? exit_cell : exit_pass;
}

int command_schema(const Place&, const Options& options) {
  if (options.input.empty() || options.input == "scenario") {
    fmt::print("{}\n", scenario_schema());
    return exit_pass;
  }
  if (options.input != "rows")
    throw InputError(fmt::format("schema: found `{}`; expected scenario or rows", options.input));
  const json text = {{"type", "string"}};
  const json number_or_empty = {{"type", json::array({"number", "string", "null"})}};
  json properties = json::object();
  for (const char* name : {"scenario", "method"}) properties[name] = text;
  properties["steps"] = {{"type", "integer"}, {"description", "0 for figures of a whole ladder"}};
  properties["h_s"] = {{"type", "number"}, {"description", "t_end_s / steps"}};
  properties["body"] = text;
  properties["t_s"] = number_or_empty;
  for (const char* name : {"metric", "unit"}) properties[name] = text;
  properties["value"] = {{"type", json::array({"number", "string"})}, {"description", "a string when not finite"}};
  properties["truth_bar"] = {
      {"type", json::array({"number", "string"})},
      {"description",
       "the truth's half-width; of an order or exponent: half of its 95 % interval; of a time: the farther end of its "
       "median's interval, nan of a single repeat"}};
  properties["status"] = {{"enum", {"ok", "unsupported", "diverged", "not finite", "timeout", "crashed", "not built"}}};
  for (const char* name :
       {"reason", "settings_hash", "engine_version", "commit", "compiler", "flags", "cpu", "run_id"}) {
    properties[name] = text;
  }
  json required = json::array();
  for (const auto& [name, value] : properties.items()) required.push_back(name);
  for (const char* name : {"spacing_m", "sound_speed_m_per_s"}) {  // of scenes with fluids alone
    properties[name] = number_or_empty;
    properties[name]["description"] = "of the particles of fluids; empty, or absent in JSON, without fluids";
  }
  const json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                       {"title", "A row of results"},
                       {"type", "object"},
                       {"required", required},
                       {"properties", properties}};
  fmt::print("{}\n", schema.dump(2));
  return exit_pass;
}

}  // namespace atwood
