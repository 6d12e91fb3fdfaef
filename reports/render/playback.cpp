// The page of a playback: the player's script and style, the scene as JSON, the motion as bytes. Both are base64, which
// cannot close its own element; nothing that comes from a scene is parsed as HTML but the escaped title.
#include "reports/render/playback.hpp"

#include <fmt/format.h>

#include "assets.hpp"
#include "compressed.hpp"
#include "playback_parts.hpp"
#include "text.hpp"

namespace atwood {
namespace {

constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";

std::vector<std::size_t> every(std::int64_t samples, std::size_t n) {
  std::vector<std::size_t> kept;
  const auto last = static_cast<std::size_t>(samples);
  for (std::size_t k = 0; k < last; k += n) kept.push_back(k);
  kept.push_back(last);
  return kept;
}

struct Data {
  std::string json, motion;  // compressed, base64
  DrawnParticles particles;
};

Data data_of(const Playback& playback, const PlayedDetail& detail) {
  const Scenario& scenario = playback.scenario;
  JsonText json(false);
  MotionBlob blob;
  json.begin_object().member("id", scenario.id).member("title", scenario.title).member("claim", scenario.claim);
  json.member("source", scenario.source).member("command", playback.command);
  json.member_number("t_end", scenario.t_end_s).member_integer("samples", playback.samples);
  json.key("truth").boolean(playback.truth).member("energy_title", playback.energy_title);
  json.member("energy_unit", playback.energy_unit);
  json.key("kept").begin_array();
  for (const std::size_t k : detail.samples) json.integer(static_cast<std::int64_t>(k));
  json.end_array().key("scene");
  append_played_scene(json, scenario.scene);
  json.key("motion");
  Data data;
  data.particles = append_played_runs(json, blob, playback, detail);
  json.end_object();
  data.json = base64(deflated(json.str()));
  data.motion = base64(deflated(blob.bytes()));
  return data;
}

}  // namespace

PlaybackPage render_playback(const Playback& playback) {
  const std::string title = playback.scenario.title.empty() ? playback.scenario.id : playback.scenario.title;
  std::string head = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{} in motion</title>\n<style>",
      kPolicy, escape_html(one_line(title)));
  head += player_style;
  head += fmt::format(
      "</style></head>\n<body>\n<header><h1>{}</h1><div id=\"tools\"></div></header>\n"
      "<main id=\"app\"><noscript><p>Playback needs JavaScript.</p></noscript></main>\n",
      escape_html(one_line(title)));
  const std::string end = "</script>\n<script>" + std::string(player_script) + "</script>\n</body></html>\n";
  PlaybackPage page;
  for (std::size_t n = 1;; n *= 2) {
    const PlayedDetail detail{every(playback.samples, n), n > 1 ? 1500U : 3000U, n > 1 ? 60U : 120U};
    const Data data = data_of(playback, detail);
    const std::size_t size = head.size() + data.json.size() + data.motion.size() + end.size();
    if (size > kPlaybackLimit && detail.samples.size() > 9) continue;
    page.html = head + "<script type=\"text/plain\" id=\"data\">" + data.json +
                "</script>\n<script type=\"text/plain\" id=\"motion\">" + data.motion + end;
    page.frames = detail.samples.size();
    page.particles_drawn = data.particles.drawn, page.particles = data.particles.all;
    return page;
  }
}

}  // namespace atwood
