#include "validation/study/campaigns.hpp"

#include <chrono>

#include "validation/study/content_hash.hpp"
#include "validation/study/load_rows.hpp"
#include "validation/study/shares.hpp"

namespace atwood {
namespace {

std::int64_t nanoseconds_now() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

std::string series_of(const Cell& cell, const std::string& purpose) {
  return content_hash({"series 1", cell.campaign, purpose});
}

// A key of a cell in the campaign with this id.
std::string key_in(const Cell& cell, const ContentHash& hash, const std::string& id) {
  return cell.campaign.empty() ? std::string(hash) : content_hash({hash, "campaign", id});
}

CellKeys keys_in(const Cell& cell, const std::string& id) {
  CellKeys keys{key_in(cell, cell.accuracy_hash, id), key_in(cell, cell.timing_hash, id), ""};
  keys.measured = measured_key(cell, keys.accuracy);
  return keys;
}

// Whether the store has all of these cells that belong to the campaign, so that an interrupted run left none
// unmeasured.
bool holds_all(Store& store, const std::vector<Cell>& cells, const std::string& campaign, const std::string& id) {
  for (const Cell& cell : cells) {
    if (cell.worker < 0 || cell.campaign != campaign) continue;
    const CellKeys keys = keys_in(cell, id);
    if (store.damage(keys).empty() && store.measured_basis(keys.measured).empty()) return false;
  }
  return true;
}

}  // namespace

Campaigns Campaigns::latest(Store& store, const std::vector<Cell>& cells, const std::string& purpose) {
  Campaigns campaigns;
  for (const Cell& cell : cells) {
    if (cell.campaign.empty() || campaigns.by_cells_.contains(cell.campaign)) continue;
    auto found = store.latest_campaign(series_of(cell, purpose), false);
    campaigns.by_cells_[cell.campaign] = found ? *found : Campaign{};
  }
  return campaigns;
}

Campaigns Campaigns::begin(Store& store, const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                           const StudyOptions& options) {
  Campaigns campaigns;
  const std::string& run_id = options.provenance.run_id;
  for (const Cell& cell : cells) {
    if (cell.campaign.empty() || cell.worker < 0 || campaigns.by_cells_.contains(cell.campaign)) continue;
    const std::string series = series_of(cell, options.purpose);
    const auto last = store.latest_campaign(series, false);
    const auto completed = options.reuse ? store.latest_campaign(series, true) : std::nullopt;
    std::int64_t now = nanoseconds_now();
    if (last) now = std::max(now, last->touched + 1);  // the clock may have been set back
    Campaign campaign;
    std::string& origin = campaigns.origin_[cell.campaign];
    const bool same_run = last && last->run_id == run_id && !run_id.empty();
    // Every chunk of a lease is a run of its own: those after the first go on with its campaign, also with --fresh.
    const bool later_chunk = options.shard && same_run;
    bool anew = false;
    if (completed && !options.fresh) {
      campaign = *completed;
      origin = "cells of its last completed campaign are taken (--reuse)";
    } else if (last && options.narrowed && !same_run &&
               (options.fresh || last->complete || holds_all(store, cells, cell.campaign, last->id))) {
      campaign = *last;
      anew = true;
      origin =
          "a part of the study is measured anew in its last campaign, whose other cells stay (--reuse takes the last one)";
    } else if (last && (later_chunk || (!options.fresh && (!last->complete || same_run)))) {
      campaign = *last;
      origin = "the campaign of an interrupted run goes on (--fresh starts anew)";
    } else {
      campaign.series = series;
      campaign.engine = workers[static_cast<std::size_t>(cell.worker)].engine.name;
      // Shards never talk to each other, and their cells belong together: the same id follows from the same plan.
      campaign.id =
          options.shard
              ? content_hash({"campaign of shards 1", series, plan_hash(*options.shard->planned), last ? last->id : ""})
              : content_hash({"campaign 1", series, run_id, std::to_string(now)});
      origin = "a new campaign (--reuse takes the last one)";
    }
    campaign.run_id = run_id;
    campaign.touched = now;
    if (!anew) campaign.complete = false;  // if this part is interrupted, the campaign is not complete
    campaigns.by_cells_[cell.campaign] = campaign;
    if (anew) campaigns.forget_cells(store, cells, cell.campaign);
    store.put_campaign(campaign);
  }
  return campaigns;
}

// All cells at once: the cells that an interrupted run did not reach are then missing instead of old.
void Campaigns::forget_cells(Store& store, const std::vector<Cell>& cells, const std::string& campaign) const {
  std::vector<CellKeys> all;
  for (const Cell& cell : cells)
    if (cell.worker >= 0 && cell.campaign == campaign) all.push_back(keys(cell));
  store.forget(all);
}

void Campaigns::complete(Store& store) const {
  for (const auto& [cells, campaign] : by_cells_) {
    Campaign closed = campaign;
    closed.complete = true;
    store.put_campaign(closed);
  }
}

const std::string& Campaigns::id_of(const Cell& cell) const {
  static const std::string none;
  const auto found = by_cells_.find(cell.campaign);
  return found == by_cells_.end() ? none : found->second.id;
}

CellKeys Campaigns::keys(const Cell& cell) const { return keys_in(cell, id_of(cell)); }

std::string Campaigns::accuracy_key(const Cell& cell) const { return key_in(cell, cell.accuracy_hash, id_of(cell)); }

std::string Campaigns::origin(const Cell& cell) const {
  const auto found = origin_.find(cell.campaign);
  return found == origin_.end() ? "" : found->second;
}

}  // namespace atwood
