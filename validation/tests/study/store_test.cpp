// What goes into the store comes out to the last bit; what is wrong with it is said in words.
#include <SQLiteCpp/SQLiteCpp.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "validation/study/blob_bytes.hpp"
#include "validation/study/recording_blob.hpp"
#include "validation/study/store.hpp"
#include "validation/study/store_database.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

std::vector<Sample> samples(bool wide) {
  std::vector<Sample> all(3);
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].t_s = static_cast<Wide>(k) / 3;
    all[k].bodies.resize(2);
    all[k].bodies[1].p_m = {0.1, -0.0, wide ? static_cast<Wide>(1) / 3 : static_cast<Wide>(2)};
    all[k].bodies[0].v_m_per_s[0] = std::numeric_limits<double>::infinity();
  }
  return all;
}

void check_equal(const SampleSeries& a, const SampleSeries& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    CHECK(a[k].t_s == b[k].t_s);
    REQUIRE(a[k].bodies.size() == b[k].bodies.size());
    for (std::size_t i = 0; i < a[k].bodies.size(); ++i) {
      CHECK(a[k].bodies[i].p_m == b[k].bodies[i].p_m);
      CHECK(a[k].bodies[i].q_wxyz == b[k].bodies[i].q_wxyz);
      CHECK(a[k].bodies[i].v_m_per_s == b[k].bodies[i].v_m_per_s);
      CHECK(a[k].bodies[i].w_rad_per_s == b[k].bodies[i].w_rad_per_s);
    }
  }
}

}  // namespace

TEST_CASE("samples and events are packed to the last bit, in 8 bytes where that is enough") {
  check_equal(unpack_samples(pack_samples(samples(false))), samples(false));
  check_equal(unpack_samples(pack_samples(samples(true))), samples(true));
  CHECK(pack_samples(samples(false)).size() < pack_samples(samples(true)).size());
  Event event;
  event.t_s = static_cast<Wide>(1) / 7;
  event.kind = EventKind::rest;
  event.body_b = 5;
  event.vn_after_m_per_s = 9;
  const auto events = unpack_events(pack_events({event}));
  REQUIRE(events.size() == 1);
  CHECK(events[0].t_s == event.t_s);
  CHECK(events[0].kind == EventKind::rest);
  CHECK(events[0].body_b == 5);
  CHECK(events[0].vn_after_m_per_s == 9);
  const std::string bytes = pack_samples(samples(true));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK_THROWS_AS(unpack_samples(bytes.substr(0, size)), BadBlob);
  CHECK_THROWS_AS(unpack_samples(bytes + "x"), BadBlob);
}

TEST_CASE("how solvers ended and further instants are packed behind the events; recordings from before have none") {
  Recording run;
  run.events.resize(3);
  run.events[1].body_b = 7;
  const std::map<std::string, SolveTally> solvers{{"contact-sweeps", {0, 0, 3, 2, 0.5}}, {"x", {1, 2, 3, 4, 1e-300}}};
  Recording back;
  back.outcome.solvers = {{"left-over", {}}};
  unpack_beside_samples(pack_events(run.events), back);
  CHECK(back.events.size() == 3);
  CHECK(back.outcome.solvers.empty());
  CHECK(back.between.empty());
  CHECK(pack_beside_samples(run, {}) == pack_events(run.events));
  const std::string without = pack_beside_samples(run, solvers);
  unpack_beside_samples(without, back);
  CHECK(back.events[1].body_b == 7);
  CHECK(back.outcome.solvers == solvers);
  const std::size_t alone = pack_events(run.events).size();
  for (std::size_t size = 0; size < without.size(); ++size)
    if (size != alone) CHECK_THROWS_AS(unpack_beside_samples(without.substr(0, size), back), BadBlob);
  CHECK_THROWS_AS(unpack_beside_samples(without + "x", back), BadBlob);

  // 2 samples that share 4 with their ladder: instants 1 and 3 lie between them.
  const std::vector<Sample> two = samples(true);
  run.values = SampleSeries({two[0], two[1], two[1]});
  run.between = SampleSeries({two[0], two[1]});
  run.shared = 4;
  for (const auto& of : {solvers, std::map<std::string, SolveTally>{}}) {
    const std::string bytes = pack_beside_samples(run, of);
    back.values = run.values;
    unpack_beside_samples(bytes, back);
    CHECK(back.shared == 4);
    CHECK(back.outcome.solvers == of);
    REQUIRE(back.between.size() == 2);
    CHECK(back.between[1].t_s == two[1].t_s);
    const std::size_t before = of.empty() ? alone + 8 : without.size();  // what a recording without instants may be
    for (std::size_t size = 0; size < bytes.size(); ++size)
      if (size != alone && size != before) CHECK_THROWS_AS(unpack_beside_samples(bytes.substr(0, size), back), BadBlob);
    back.values.truncate(2);  // instants of another number of samples
    CHECK_THROWS_AS(unpack_beside_samples(bytes, back), BadBlob);
  }
}

TEST_CASE("contacts are packed with their samples") {
  std::vector<Sample> touching = samples(false);
  touching[0].contacts = {{0, 1, {1, 2, 3}, {0, 0, 1}, -1e-9, 9.8, {0.5, 0, -0.25}}};
  const std::string bytes = pack_samples(touching);
  const SampleSeries unpacked = unpack_samples(bytes);
  CHECK(copy_of(unpacked[0]).contacts == touching[0].contacts);
  CHECK(unpacked[1].contacts.empty());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK_THROWS_AS(unpack_samples(bytes.substr(0, size)), BadBlob);
}

TEST_CASE("particles are packed with their samples; recordings without any are as they were") {
  for (const bool wide : {false, true}) {
    std::vector<Sample> flowing = samples(wide);
    const std::string without = pack_samples(flowing);
    ParticleSample& p = flowing[1].particles.emplace_back();
    p.p_m = {1, 2, 3}, p.v_m_per_s = {4, 5, 6};
    p.density_kg_per_m3 = 7, p.pressure_Pa = 8, p.temperature_K = wide ? static_cast<Wide>(1) / 3 : Wide(9);
    const std::string bytes = pack_samples(flowing);
    CHECK(static_cast<int>(without[0]) == (wide ? 16 : 8));
    const SampleSeries back = unpack_samples(bytes);
    check_equal(back, flowing);
    CHECK(back[0].particles.empty());
    REQUIRE(back[1].particles.size() == 1);
    CHECK(back[1].particles[0].p_m == p.p_m);
    CHECK(back[1].particles[0].v_m_per_s == p.v_m_per_s);
    CHECK(back[1].particles[0].density_kg_per_m3 == 7);
    CHECK(back[1].particles[0].pressure_Pa == 8);
    CHECK(back[1].particles[0].temperature_K == flowing[1].particles[0].temperature_K);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      CHECK_THROWS_AS(unpack_samples(bytes.substr(0, size)), BadBlob);
    CHECK_THROWS_AS(unpack_samples(bytes + "x"), BadBlob);
  }
}

TEST_CASE("joints and ropes are packed with their samples; recordings without any are as they were") {
  for (const bool wide : {false, true}) {
    std::vector<Sample> linked = samples(wide);
    const Wide third = wide ? static_cast<Wide>(1) / 3 : Wide(0.375);
    JointSample& joint = linked[1].joints.emplace_back();
    joint.q = {1, 2, 3, 4}, joint.u = {5, 6, third}, joint.force_N = {8, 9, std::nan("")},
    joint.torque_N_m = {11, 12, 13};
    joint.not_unique = 0b101001, joint.applied = {14, 15, 16};
    RopeSample& rope = linked[1].ropes.emplace_back();
    rope.tension_N = 17, rope.pulley_angle_rad = {18, third};
    linked[0].particles.resize(1);
    const std::string bytes = pack_samples(linked);
    const SampleSeries back = unpack_samples(bytes);
    check_equal(back, linked);
    CHECK(back[0].joints.empty());
    CHECK(back[0].particles.size() == 1);
    REQUIRE(back[1].joints.size() == 1);
    const JointSample& read = back[1].joints[0];
    CHECK(read.q == joint.q);
    CHECK(read.u == joint.u);
    CHECK(read.force_N[1] == 9);
    CHECK(read.force_N[2] != read.force_N[2]);  // not reported
    CHECK(read.torque_N_m == joint.torque_N_m);
    CHECK(read.not_unique == joint.not_unique);
    CHECK(read.applied == joint.applied);
    REQUIRE(back[1].ropes.size() == 1);
    CHECK(back[1].ropes[0].tension_N == 17);
    CHECK(back[1].ropes[0].pulley_angle_rad == rope.pulley_angle_rad);
    for (std::size_t size = 0; size < bytes.size(); ++size)
      CHECK_THROWS_AS(unpack_samples(bytes.substr(0, size)), BadBlob);
    CHECK_THROWS_AS(unpack_samples(bytes + "x"), BadBlob);
  }
}

TEST_CASE("the picture of a fluid is packed behind the series; series without one are as they were") {
  Series series;
  series.t_s = {0, 1};
  series.position_m = {0, 1e-3};
  FluidPicture picture, back;
  CHECK(pack_series_and_picture(series, picture) == pack_series(series));
  CHECK(unpack_series_and_picture(pack_series(series), back).t_s == series.t_s);
  CHECK(back.empty());
  picture.t_s = 0.5, picture.side_m = 0.02, picture.particles = 10000;
  picture.low_m = {0, -1}, picture.high_m = {1, 2};
  picture.error_of = "velocity [m/s]";
  picture.x_m = {0.1f, 0.9f}, picture.y_m = {0.2f, 0.8f}, picture.speed_m_per_s = {1, 2}, picture.pressure_Pa = {-3, 4};
  picture.error = {1e-6f, 1e-5f};
  const std::string bytes = pack_series_and_picture(series, picture);
  CHECK(unpack_series_and_picture(bytes, back).position_m == series.position_m);
  CHECK(back.particles == 10000);
  CHECK(back.error_of == picture.error_of);
  CHECK(back.high_m == picture.high_m);
  CHECK(back.pressure_Pa == picture.pressure_Pa);
  CHECK(back.error == picture.error);
  CHECK(back.temperature_K.empty());
  CHECK_THROWS_AS(unpack_series_and_picture(bytes.substr(0, bytes.size() - 1), back), BadBlob);
  picture.y_m.pop_back();
  CHECK_THROWS_AS(unpack_series_and_picture(pack_series_and_picture(series, picture), back), BadBlob);
}

TEST_CASE("a cell, its rows, its truth and its times come back as they went in") {
  const Folder folder;
  RunRecord run;
  run.outcome.steps_taken = 64;
  run.outcome.rate_evaluations = 256;
  run.wall_ns = 5;
  run.limit_s = 20;
  run.provenance = {"1", "commit", "g++", "-O3", "cpu", "run", "avx2 fma", "glibc 2.36"};
  Recording recording{samples(true), {}, run.outcome};
  MeasuredRecord measured;
  measured.basis = "basis";
  measured.series.t_s = {0, 1};
  measured.series.energy = {0, std::nan("")};
  measured.rows.resize(2);
  measured.rows[0].metric = "error-position-max";
  measured.rows[0].value = std::nan("");
  measured.rows[0].truth_bar = std::numeric_limits<double>::infinity();
  measured.rows[1].t_s = 0.1;
  measured.rows[1].spacing_m = 0.02;
  measured.rows[1].body = "ball";
  measured.rows[1].value = 1.0 / 3;
  measured.rows[1].status = Status::not_finite;
  measured.rows[1].reason = "it's \"so\"";
  Truth truth;
  truth.source = "closed form";
  truth.values = truth.bars = samples(true);
  truth.event_bar_s = {1e-20};
  truth.events.resize(1);
  TimingRecord timing;
  timing.outcome.busy_ns = {3, 1, 2};
  {
    Store store(folder / "store.db", Store::Mode::write);
    store.put_run("cell", run, recording, "key", measured);
    store.put_truth("truth", "one", truth);
    store.put_timing("timing", "cell", timing);
  }
  Store store(folder / "store.db", Store::Mode::read);
  const auto back = store.run("cell");
  REQUIRE(back);
  CHECK(back->outcome.rate_evaluations == 256);
  CHECK(back->provenance.flags == "-O3");
  CHECK(back->provenance.run_id == "run");
  CHECK(back->provenance.cpu_features == "avx2 fma");
  CHECK(back->provenance.libm == "glibc 2.36");
  CHECK_FALSE(store.run("another"));
  check_equal(store.recording("cell", back->outcome).values, samples(true));
  const auto rows = store.measured("key", true, true);
  REQUIRE(rows);
  REQUIRE(rows->rows.size() == 2);
  CHECK(std::isnan(rows->rows[0].value));
  CHECK(std::isinf(rows->rows[0].truth_bar));
  CHECK_FALSE(rows->rows[0].t_s);
  CHECK(rows->rows[1].t_s == 0.1);
  CHECK(rows->rows[1].spacing_m == 0.02);
  CHECK_FALSE(rows->rows[1].sound_speed_m_per_s);
  CHECK(rows->rows[1].value == 1.0 / 3);
  CHECK(rows->rows[1].status == Status::not_finite);
  CHECK(rows->rows[1].reason == "it's \"so\"");
  CHECK(rows->series.t_s == measured.series.t_s);
  CHECK(std::isnan(rows->series.energy.at(1)));
  check_equal(store.truth("truth")->bars, samples(true));
  CHECK(store.truth("truth")->event_bar_s == truth.event_bar_s);
  CHECK(store.timing("timing")->outcome.busy_ns == timing.outcome.busy_ns);
}

TEST_CASE("a truth of very many samples is stored in parts, and one whose part has gone is damaged") {
  const Folder folder;
  Sample sample;
  sample.bodies.resize(100);
  Truth truth;
  truth.source = "closed form";
  for (int k = 0; k < 2000; ++k) {  // 42 MB
    sample.t_s = static_cast<Wide>(k) / 3;
    sample.bodies[k % 100].p_m[0] = sample.t_s;
    truth.values.push_back(sample);
    truth.bars.push_back(Sample{sample.t_s, std::vector<BodySample>(100)});
  }
  truth.event_bar_s = {1e-20};
  {
    Store store(folder / "store.db", Store::Mode::write);
    store.put_truth("truth", "one", truth);
    store.put_truth("truth two", "two", Truth{});
  }
  const auto count = [&](const std::string& key) {
    SQLite::Database database(folder / "store.db", SQLite::OPEN_READWRITE);
    return database.execAndGet("SELECT count(*) FROM truths WHERE hash LIKE '" + key + "'").getInt();
  };
  CHECK(count("truth part %") == 10);
  {
    Store store(folder / "store.db", Store::Mode::read);
    CHECK(store.has_truth("truth"));
    const auto back = store.truth("truth");
    REQUIRE(back);
    check_equal(back->values, truth.values);
    check_equal(back->bars, truth.bars);
    CHECK(back->event_bar_s == truth.event_bar_s);
    CHECK(back->source == "closed form");
  }
  SQLite::Database(folder / "store.db", SQLite::OPEN_READWRITE).exec("DELETE FROM truths WHERE hash='truth part 1'");
  Store store(folder / "store.db", Store::Mode::write);
  CHECK_THROWS_AS(store.truth("truth"), StoreDamage);
  CHECK(store.truth_damage("truth") != "");
  store.forget_truth("truth");
  CHECK_FALSE(store.has_truth("truth"));
  CHECK(store.has_truth("truth two"));
  CHECK(count("truth%") == 1);
}

TEST_CASE("what an entry of a truth in parts says of its size takes no memory before the parts are read") {
  const Folder folder;
  const std::string path = folder / "store.db";
  Truth truth;
  truth.source = "closed form";
  { Store(path, Store::Mode::write).put_truth("truth", "one", truth); }
  const auto claim = [&](std::initializer_list<std::uint64_t> parts_samples_bodies) {
    BlobWriter samples;
    samples.put(std::uint8_t{128});
    for (const std::uint64_t number : parts_samples_bodies) samples.put(number);
    const std::string events = pack_events({}), event_bars = pack_reals({});
    StoreDatabase database;
    database.path = path;
    database.open_for_writing();
    database.written([&] {
      database.erase(kTruths, "truth");
      database.insert(kTruths, {"truth", "one", to_string(Status::ok), "", "closed form", "", 0.0, Blob{samples.bytes},
                                Blob{}, Blob{events}, Blob{event_bars}});
    });
  };
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 40;
  for (const auto& [parts, samples, bodies] : {std::tuple{std::uint64_t{2}, kHuge, std::uint64_t{1}},
                                               {std::uint64_t{2}, kHuge << 20, kHuge << 16},
                                               {std::uint64_t{2}, std::uint64_t{1}, kHuge},
                                               {kHuge, kHuge, std::uint64_t{0}}}) {
    claim({parts, samples, bodies});
    Store store(path, Store::Mode::read);
    CHECK_THROWS_WITH(store.truth("truth"), Catch::Contains("a part of a truth cannot be found"));
  }
}

TEST_CASE("a store that cannot be used says why") {
  const Folder folder;
  const auto write = [&](const std::string& name) { Store store(folder / name, Store::Mode::write); };
  CHECK_THROWS_WITH(write("nowhere/store.db"), Catch::Contains("No such file or directory"));
  std::ofstream(folder / "text.db") << std::string(5000, 'x');
  CHECK_THROWS_WITH(write("text.db"), Catch::Contains("is not a store"));
  CHECK(std::filesystem::file_size(folder / "text.db") == 5000);  // and is left alone
  {
    Store held(folder / "held.db", Store::Mode::write);
    CHECK_THROWS_WITH(write("held.db"), Catch::Contains("in use by another run"));
    CHECK_NOTHROW(Store(folder / "held.db", Store::Mode::read));
  }
  CHECK_NOTHROW(write("held.db"));
  MeasuredRecord measured;
  measured.basis = "basis";
  {
    Store store(folder / "cut.db", Store::Mode::write);
    for (int i = 0; i < 200; ++i)
      store.put_measured("key " + std::to_string(i) + std::string(500, 'k'), "cell", measured);
  }
  std::filesystem::resize_file(folder / "cut.db", std::filesystem::file_size(folder / "cut.db") / 2);
  CHECK_THROWS_WITH(
      [&] {
        Store store(folder / "cut.db", Store::Mode::write);
        for (int i = 0; i < 200; ++i) store.measured("key " + std::to_string(i) + std::string(500, 'k'), true, true);
      }(),
      Catch::Contains("damaged"));
}
