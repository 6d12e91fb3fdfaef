// A share of a study instead of the whole (`run --shard`, under a launcher, `--lease`).
#pragma once

#include <optional>

#include "reports/command_line/command_line.hpp"
#include "validation/study/shares.hpp"

namespace atwood {

// That of --shard, else the launcher's; empty: this process runs the whole study.
std::optional<StudyShare> share_of(const Options& options);
int dry_run(const Selection& selection, const Options& options, const std::optional<StudyShare>& share);
// `share` empty: with --lease and without a launcher.
int run_share(const Place& place, const Options& options, const Selection& selection,
              const std::optional<StudyShare>& share);

}  // namespace atwood
