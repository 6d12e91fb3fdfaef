// Checks of settings in method ids: unknown names and values that are not allowed. The rules that an engine declares
// (type, range, choices; the engines of this tree declare them all) are applied without running it. Settings without a
// rule, and several settings of one id, which may contradict one another, are tested by running a small scene: if the
// engine refuses the method with its settings and runs it without them, the settings are wrong, and the engine's reason
// is the message.
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "scene/files.hpp"
#include "validation/study/study.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

constexpr double kLimitS = 10;
constexpr int kMaxFailures = 2;  // ids of one engine that crash or time out; those after them are not tried

// A ball over a floor with restitution, the same without, and a point in free fall: every engine that moves bodies runs
// one of the three.
constexpr const char* kScene =
    "id = \"small\"\ntitle = \"A small scene\"\nclaim = \"Settings are read\"\nsource = \"none\"\n[run]\nt_end_s = 1e-6\n"
    "steps = [1]\nsamples = 1\n[world]\ngravity_m_per_s2 = [0, 0, -9.81]\n[truth]\nkind = \"none\"\n";
constexpr const char* kOverAFloor =
    "[[body]]\nname = \"floor\"\nshape.plane = { normal = [0, 0, 1], offset_m = 0 }\n"
    "[[body]]\nname = \"ball\"\nmass_kg = 1\nshape.sphere = { radius_m = 0.5 }\nposition_m = [0, 0, 0.6]\n";
constexpr const char* kBouncing = "[material.default]\nrestitution = 0.5\n";
constexpr const char* kInTheAir = "[[body]]\nname = \"point\"\nmass_kg = 1\nposition_m = [0, 0, 1]\n";

// As the engines take it.
struct SmallScene {
  std::string json;
  SampledBodies bodies;
};

bool is_ours(const Worker& worker) {
  return std::filesystem::path(worker.path).filename().string().rfind("atwood-", 0) == 0;
}

std::string listed(const Settings& settings) {
  std::string names;
  for (const auto& [name, standard] : settings) names += (names.empty() ? "" : ", ") + name;
  return names;
}

const MethodInfo* find(const std::vector<MethodInfo>& all, const std::string& id) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const MethodInfo& info) { return info.id == id; });
  return found == all.end() ? nullptr : &*found;
}

// What is wrong with the settings of an id; empty where no fault is known.
class Judge {
 public:
  explicit Judge(const std::vector<Worker>& workers) : workers_(workers) {
    for (const std::string& bodies :
         {std::string(kBouncing) + kOverAFloor, std::string(kOverAFloor), std::string(kInTheAir)}) {
      const Scene scene = read_scenario_text(kScene + bodies, "a small scene", ".").scene;
      scenes_.push_back({scene_to_json(scene), sampled_bodies(scene)});
    }
  }

  const std::string& fault(const std::string& method) {
    const auto [place, fresh] = faults_.try_emplace(method);
    if (fresh) place->second = find_fault(method);
    return place->second;
  }

 private:
  std::string find_fault(const std::string& method) {
    const MethodId id = parse_method_id(method);
    if (id.overrides.empty()) return "";
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      const Worker& worker = workers_[i];
      if (worker.status != Status::ok) continue;
      const MethodInfo* info = find(worker.engine.methods, id.engine + "/" + id.scheme);
      if (info == nullptr) continue;
      // A foreign engine may list no settings; it then checks them when it runs.
      if (info->settings.empty() && !is_ours(worker)) return "";
      const MethodInfo* response = id.response.empty() ? nullptr : find(worker.engine.responses, "+" + id.response);
      if (const std::string unknown = unknown_name(id, *info, response); !unknown.empty()) return unknown;
      if (const std::string value = wrong_value(id, *info, response); !value.empty()) return value;
      // Values that are each in range may contradict one another; our own engine has no such settings.
      const bool may_contradict = id.overrides.size() > 1 && id.engine != "atwood";
      return has_rules(id, *info, response) && !may_contradict ? "" : refused_value(i, id);
    }
    return "";
  }

  // The fault by the declared rules of method and response; a setting that both have must satisfy both.
  static std::string wrong_value(const MethodId& id, const MethodInfo& info, const MethodInfo* response) {
    for (const MethodInfo* owner : {&info, response}) {
      if (owner == nullptr) continue;
      Settings own;
      for (const auto& [key, value] : id.overrides)
        if (owner->rules.contains(key)) own[key] = value;
      if (const Result<Settings> merged = merged_settings(*owner, own); !merged) return merged.fault().reason;
    }
    return "";
  }

  // Whether every setting of the id has a rule wherever it is listed.
  static bool has_rules(const MethodId& id, const MethodInfo& info, const MethodInfo* response) {
    const auto has = [](const MethodInfo* owner, const std::string& key) {
      return owner == nullptr || !owner->settings.contains(key) || owner->rules.contains(key);
    };
    return std::all_of(id.overrides.begin(), id.overrides.end(),
                       [&](const auto& entry) { return has(&info, entry.first) && has(response, entry.first); });
  }

  static std::string unknown_name(const MethodId& id, const MethodInfo& info, const MethodInfo* response) {
    for (const auto& [key, value] : id.overrides) {
      if (info.settings.contains(key) || (response && response->settings.contains(key))) continue;
      const std::string names = listed(info.settings);
      if (response)
        return "neither " + info.id + " nor " + response->id + " has a setting `" + key + "`; expected one of " +
               response->id + "'s: " + listed(response->settings) +
               (names.empty() ? "" : "; or " + info.id + "'s: " + names);
      return info.id + " has no setting `" + key + "`; expected " +
             (names.empty() ? "none: it has no settings" : "one of " + names);
    }
    return "";
  }

  // Values that crash the engine or take too long are not refused here: the run itself reports each of them.
  std::string refused_value(std::size_t worker, const MethodId& id) {
    int& failures = failures_[worker];
    if (failures >= kMaxFailures) return "";
    MethodId plain = id;
    plain.overrides.clear();
    const SmallScene* scene = scene_for(worker, plain);
    if (scene == nullptr) return "";
    const Outcome outcome = run(worker, id, *scene);
    if (outcome.status == Status::crashed || outcome.status == Status::timeout) ++failures;
    return outcome.status == Status::unsupported ? outcome.reason : "";
  }

  // The first scene that the engine runs by the method without settings; null: none.
  const SmallScene* scene_for(std::size_t worker, const MethodId& plain) {
    const auto [place, fresh] = runs_.try_emplace({worker, to_string(plain)}, nullptr);
    if (!fresh) return place->second;
    for (const SmallScene& scene : scenes_) {
      const Status status = run(worker, plain, scene).status;
      if (status == Status::unsupported || status == Status::crashed || status == Status::timeout ||
          status == Status::not_built)
        continue;
      place->second = &scene;
      break;
    }
    return place->second;
  }

  Outcome run(std::size_t worker, const MethodId& id, const SmallScene& scene) {
    WorkerClient& client = clients_.try_emplace(worker, workers_[worker]).first->second;
    return client.run(to_string(id), scene.json, scene.bodies, {1e-6, 1, 1, {}}, 0, kLimitS).outcome;
  }

  const std::vector<Worker>& workers_;
  std::vector<SmallScene> scenes_;
  std::map<std::pair<std::size_t, std::string>, const SmallScene*> runs_;  // by worker and method without settings
  std::map<std::size_t, int> failures_;                                    // by worker: ids that crashed or timed out
  std::map<std::string, std::string> faults_;
  std::map<std::size_t, WorkerClient> clients_;
};

}  // namespace

void check_settings(const std::string& who, const std::vector<Cell>& cells, const std::vector<Worker>& workers) {
  const BrokenPipeGuard guard;
  Judge judge(workers);
  std::map<std::string, std::string> first_fault;  // by glob: the fault of the first id that the glob gave
  std::set<std::string> taken;
  try {
    const std::string* last = nullptr;  // the last method found without fault: cells of one method follow each other
    for (const Cell& cell : cells) {
      if (cell.worker < 0) continue;
      const bool glob = cell.pattern.find_first_of("*?") != std::string::npos;
      if (!glob && last != nullptr && *last == cell.method) continue;
      const std::string& fault = judge.fault(cell.method);
      if (glob && fault.empty()) taken.insert(cell.pattern);
      if (fault.empty()) last = &cell.method;
      if (fault.empty()) continue;
      const std::string words = who + cell.method + ": " + fault;
      if (!glob) throw InputError(words);
      first_fault.try_emplace(cell.pattern, words);
    }
  } catch (const Interrupted&) {
    return;  // the caller checks for the signal
  }
  for (const auto& [pattern, words] : first_fault)
    if (!taken.contains(pattern)) throw InputError(words);
}

void check_settings(const std::string& who, const std::string& method, const std::vector<Worker>& workers) {
  const BrokenPipeGuard guard;
  const std::string fault = Judge(workers).fault(method);
  if (!fault.empty()) throw InputError(who + method + ": " + fault);
}

}  // namespace atwood
