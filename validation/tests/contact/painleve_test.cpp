// Painleve's configurations under `+event`: a rod that slides on its end where friction presses it into the floor.
//
// The plane theory, by hand. A uniform rod of mass m and length 2 a, at an angle theta from the floor, touches it with
// its lower end; its centre of mass is ahead by a c and above by a s (c = cos, s = sin; r of the end -a c, -a s). With
// impulses p (up) and q (ahead) at the end and I = m a^2 / 3:
//   m d(v_n) = (1 + 3 c^2) dp - 3 s c dq       m d(v_t) = -3 s c dp + (1 + 3 s^2) dq
// Slip towards -x has q = mu p: k m = 1 + 3 c^2 - 3 mu s c < 0 where mu > (1 + 3 c^2) / (3 s c); 4/3 at tan theta = 2.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "recorded.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

constexpr double g = 9.81, half_m = 0.5, thin_m = 1e-12, mass_kg = 2;

struct Slide {
  double tangent = 2, friction = 1.5, restitution = 0, speed = -1, heading = 0, unit_m = 1, spin = 0;
};

// Slides on its end at `speed` towards `heading`, its centre of mass ahead; turns about its end with `spin`.
Scene sliding_rod(const Slide& of) {
  const double theta = std::atan(of.tangent), c = std::cos(theta), s = std::sin(theta), u = of.unit_m;
  const double hx = std::cos(of.heading), hy = std::sin(of.heading), lean = M_PI / 2 - theta, a = half_m * u;
  Scene scene = world({0, 0, -g * u}, of.restitution, of.friction);
  const double v = of.speed * u, up = a * s + thin_m * u, ahead = a * c;
  const double vx = v + of.spin * up, vz = -of.spin * ahead;
  Body rod = moving("rod", Capsule{thin_m * u, a}, mass_kg, {a * a / 3, a * a / 3, 1e-4 * u * u}, {0, 0, up},
                    {vx * hx, vx * hy, vz});
  // about z by the heading, then about the body's y by the lean
  const double cl = std::cos(lean / 2), sl = std::sin(lean / 2), ch = std::cos(of.heading / 2),
               sh = std::sin(of.heading / 2);
  rod.orientation_wxyz = {ch * cl, -sh * sl, ch * sl, sh * cl};
  rod.angular_velocity_body_rad_per_s = {0, of.spin, 0};
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), rod};
  return scene;
}

double threshold(double tangent) {
  const double theta = std::atan(tangent), c = std::cos(theta), s = std::sin(theta);
  return (1 + 3 * c * c) / (3 * s * c);
}

double energy(const Sample& sample, const Body& body, double gravity) {
  const Real3 v = Recorded::doubles(sample.bodies[1].v_m_per_s), w = Recorded::doubles(sample.bodies[1].w_rad_per_s);
  double sum = body.mass_kg * gravity * static_cast<double>(sample.bodies[1].p_m[2]);
  for (int k = 0; k < 3; ++k) sum += (body.mass_kg * v[k] * v[k] + body.inertia_kg_m2[4 * k] * w[k] * w[k]) / 2;
  return sum;
}

double lowest(const Sample& sample, const Slide& of) {
  const auto& q = sample.bodies[1].q_wxyz;
  const double axis_z = static_cast<double>(1 - 2 * (q[1] * q[1] + q[2] * q[2]));
  return static_cast<double>(sample.bodies[1].p_m[2]) - of.unit_m * (half_m * std::abs(axis_z) + thin_m);
}

// A rod on its end or a board on its edge, in a random configuration near the threshold.
struct RandomSlide {
  Scene scene;
  double half_thickness_m = 0, half_width_m = 0;  // 0: a rod
};
RandomSlide random_slide(int seed) {
  std::mt19937_64 random(static_cast<unsigned>(seed));
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  const double theta = uniform(15, 88) * M_PI / 180, c = std::cos(theta), s = std::sin(theta), lean = M_PI / 2 - theta;
  const double b = uniform(0.01, 0.2), d = uniform(1e-3, 0.05), speed = uniform(-3, 3), spin = uniform(-4, 4),
               heading = uniform(0, 6.28), e = uniform(0, 1), mu = threshold(std::tan(theta)) * uniform(0.5, 2.5);
  if (seed % 2 == 1) return {sliding_rod({std::tan(theta), mu, e, speed, heading, 1, spin})};
  const double up = half_m * s + d * c, ahead = half_m * c - d * s, vx = speed + spin * up;
  RandomSlide made{world({0, 0, -g}, e, mu), d, b};
  Body board =
      box("rod", mass_kg, {d, b, half_m}, {0, 0, up}, {vx * std::cos(heading), vx * std::sin(heading), -spin * ahead});
  const double cl = std::cos(lean / 2), sl = std::sin(lean / 2), ch = std::cos(heading / 2), sh = std::sin(heading / 2);
  board.orientation_wxyz = {ch * cl, -sh * sl, ch * sl, sh * cl};
  board.angular_velocity_body_rad_per_s = {0, spin, 0};
  made.scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), board};
  return made;
}

double lowest(const Sample& sample, const RandomSlide& of) {
  if (of.half_width_m == 0) return lowest(sample, Slide{});
  double q[4];
  for (int k = 0; k < 4; ++k) q[k] = static_cast<double>(sample.bodies[1].q_wxyz[k]);
  return static_cast<double>(sample.bodies[1].p_m[2]) -
         of.half_thickness_m * std::abs(2 * (q[1] * q[3] - q[0] * q[2])) -
         of.half_width_m * std::abs(2 * (q[2] * q[3] + q[0] * q[1])) -
         half_m * std::abs(1 - 2 * (q[1] * q[1] + q[2] * q[2]));
}

}  // namespace

// Compression: along q = mu p until v_t = 0, v_n falls; then sticking, dq / dp = 3 s c / (1 + 3 s^2), back to v_n = 0.
// Both phases are straight lines of the (p, q) plane: the impulse in closed form.
TEST_CASE("a rod in Painleve's inconsistent case takes the impact without collision of the plane theory") {
  for (const double tangent : {2., 1., 3.})
    for (const double beyond : {1e-4, 0.1, 1., 5.})
      for (const double e : {0., 0.5, 1.})
        for (const double heading : {0., 2.5})
          for (const char* law : {"poisson", "stronge"}) {
            Slide of{tangent, threshold(tangent) + beyond, e};
            of.heading = heading;
            const double theta = std::atan(tangent), c = std::cos(theta), s = std::sin(theta), mu = of.friction;
            const double slide = 3 * s * c, up = 1 + 3 * c * c, ahead = 1 + 3 * s * s;  // K = these / m
            const double k = up - mu * slide;
            const double p_stop = mass_kg * -of.speed / (mu * ahead - slide), vn_stop = k * p_stop / mass_kg;
            const double hold = slide / ahead, k_hold = up - slide * hold;
            if (hold > mu) continue;  // it slips back: not this formula
            const double p_more = -vn_stop * mass_kg / k_hold, p_c = p_stop + p_more;
            const double lost = mass_kg * vn_stop * vn_stop / 2 * (1 / k - 1 / k_hold);  // work of compression, < 0
            const double p_back = std::string(law) == "poisson" ? e * p_c : e * std::sqrt(-2 * lost * mass_kg / k_hold);
            const double p = p_c + p_back, vn = k_hold * p_back / mass_kg;
            const Recorded it =
                run(std::string("atwood/rk4+event{restitution=") + law + "}", sliding_rod(of), {1e-6, 1, 1});
            INFO("tan " << tangent << " mu " << mu << " e " << e << " " << law << " " << it.outcome.reason);
            REQUIRE(it.events.size() >= 1);
            CHECK(it.events[0].kind == EventKind::impact);
            CHECK(it.events[0].t_s == 0);
            CHECK(static_cast<double>(it.events[0].impulse_n_N_s) == Approx(p).epsilon(1e-6));
            CHECK(static_cast<double>(it.events[0].vn_after_m_per_s) == Approx(vn).epsilon(1e-6).margin(1e-12));
            CHECK(it.v(1)[2] == Approx(p / mass_kg).epsilon(1e-4));
          }
}

TEST_CASE("under newton the inconsistent case ends the run with its reason and time") {
  const Recorded it = try_run("atwood/rk4+event", sliding_rod({}), {0.5, 100, 100});
  CHECK(it.outcome.status == Status::unsupported);
  CHECK(it.outcome.reason.find("inconsistent") != std::string::npos);
  CHECK(it.outcome.reason.find("t = 0 s") != std::string::npos);
  CHECK(it.samples.size() <= 1);
}

TEST_CASE("a rod that friction could press on although it would lift off is indeterminate") {
  Slide of;
  of.spin = 12;  // w^2 a s > g: the end would rise by itself
  for (const char* law : {"newton", "poisson", "stronge"}) {
    const Recorded it =
        try_run(std::string("atwood/rk4+event{restitution=") + law + "}", sliding_rod(of), {0.1, 10, 10});
    INFO(law);
    CHECK(it.outcome.status == Status::unsupported);
    CHECK(it.outcome.reason.find("indeterminate") != std::string::npos);
  }
}

// Far from the threshold, next to it on both sides, in other units and directions.
TEST_CASE("a rod that slides on its end neither penetrates the floor nor gains energy") {
  int answered = 0;
  for (const char* method : {"atwood/rk4+event", "atwood/dop853:1e-10+event"})
    for (const char* law : {"newton", "poisson", "stronge"})
      for (const double tangent : {0.7, 2., 3.})
        for (const double beyond : {-0.5, -1e-12, 1e-12, 0.2, 8.})
          for (const double speed : {-1., 2.})
            for (const double e : {0., 0.6})
              for (const double unit : {1., 1e-3, 1e6}) {
                Slide of{tangent, threshold(tangent) + beyond, e, speed, unit == 1 ? 0. : 0.9, unit};
                const Scene scene = sliding_rod(of);
                const Recorded it = try_run(std::string(method) + "{restitution=" + law + "}", scene, {0.25, 50, 50});
                INFO(method << " " << law << " tan " << tangent << " mu " << of.friction << " v " << speed << " e " << e
                            << " unit " << unit << ": " << it.outcome.reason);
                CHECK((it.outcome.status == Status::ok || it.outcome.status == Status::unsupported));
                if (std::string(law) != "newton") CHECK(it.outcome.status == Status::ok);
                answered += it.outcome.status == Status::ok;
                double before = energy(it.samples[0], scene.bodies[1], g * unit);
                const double scale = std::abs(before);
                for (const Sample& sample : it.samples) {
                  const double now = energy(sample, scene.bodies[1], g * unit);
                  CHECK(now <= before + 1e-8 * scale);
                  CHECK(lowest(sample, of) >= -1e-9 * unit);
                  before = now;
                }
              }
  CHECK(answered > 600);
}

// After the impact the end is at rest and its centripetal acceleration nearly carries the rod: the floor would have to
// pull on an end that stuck. It slips ahead from rest instead, with q = -mu p: k m = 1 + 3 c^2 + 3 mu s c > 0 gives one
// force.
TEST_CASE("an end that would have to be pulled to stay at rest slips off under the force of the plane theory") {
  const double part = 0.9;  // of the weight that the centripetal acceleration carries
  for (const bool edge : {false, true})
    for (const double tangent : {0.5, 0.95626, 1.1423, 2.})
      for (const double beyond : {0.3, 1.5, 4.})
        for (const double heading : {0., 2.5, M_PI})
          for (const double unit : {1., 1e-6})
            for (const bool floor_last : {false, true}) {
              Slide of{tangent, threshold(tangent) + beyond, 0};
              of.heading = heading;
              of.unit_m = unit;
              const double theta = std::atan(tangent), c = std::cos(theta), s = std::sin(theta), mu = of.friction;
              const double slide = 3 * s * c, up = 1 + 3 * c * c, ahead = 1 + 3 * s * s, hold = slide / ahead;
              const double p_stop = 1 / (mu * ahead - slide);  // per unit of mass and speed
              const double p_more = -(up - mu * slide) * p_stop / (up - slide * hold);
              const double p = p_stop + p_more, q = mu * p_stop + hold * p_more;
              of.speed = -std::sqrt(part * g / (half_m * s)) * half_m / (3 * std::abs(s * q - c * p));
              const double b_n = -(1 - part) * g, b_t = part * g * c / s;
              REQUIRE(ahead * b_n + slide * b_t > 0);  // sticking would need a pull
              const double N = -b_n * mass_kg / (up + mu * slide);
              REQUIRE(b_t - N * (slide + mu * ahead) / mass_kg > 0);
              Scene scene = sliding_rod(of);
              if (edge) {  // a thin board on one edge: two contacts
                const double a = half_m * unit, w = 0.05 * unit;
                Body board = box("rod", mass_kg, {thin_m * unit, w, a}, scene.bodies[1].position_m,
                                 scene.bodies[1].velocity_m_per_s);
                board.position_m[2] = a * s + thin_m * unit * c;
                board.orientation_wxyz = scene.bodies[1].orientation_wxyz;
                scene.bodies[1] = board;
              }
              const int rod = floor_last ? 0 : 1;
              if (floor_last) std::swap(scene.bodies[0], scene.bodies[1]);
              for (const char* law : {"poisson", "stronge"}) {
                const Recorded it =
                    run(std::string("atwood/dop853+event{restitution=") + law + "}", scene, {1e-8, 1, 1});
                INFO((edge ? "edge" : "end")
                     << " tan " << tangent << " mu " << mu << " heading " << heading << " unit " << unit << " " << law);
                double force = 0, friction = 0;
                for (const auto& contact : it.samples.back().contacts) {
                  const double sign = contact.body_b == rod ? 1 : -1;
                  force += contact.force_n_N;
                  friction +=
                      sign * (contact.force_t_N[0] * std::cos(heading) + contact.force_t_N[1] * std::sin(heading));
                }
                CHECK(force == Approx(N * unit).epsilon(1e-4));
                CHECK(friction == Approx(-mu * N * unit).epsilon(1e-4));
              }
            }
}

// A coin on its rim: friction presses the rim on ever harder, N grows as the root of the time that is left.
TEST_CASE("a contact that slides into the singular configuration ends the run there") {
  const double R = 0.1, half = 0.005, up = M_PI / 2 - 0.8;
  Scene scene = world({0, 0, -g}, 0, 10);
  const double across = (3 * R * R + 4 * half * half) / 12;
  Body coin = moving("coin", Cylinder{R, half}, 0.05, {across, across, R * R / 2},
                     {0, 0, R * std::sin(up) + half * std::cos(up)}, {0.5, 0.2, 0}, {0.3, 0, 0});
  coin.orientation_wxyz = {std::cos(up / 2), std::sin(up / 2), 0, 0};
  scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), coin};
  for (const char* method : {"atwood/dop853:1e-10+event{restitution=stronge}", "atwood/dopri5:1e-9+event"}) {
    const Recorded it = try_run(method, scene, {0.5, 500, 500});
    INFO(method << " " << it.outcome.reason);
    CHECK(it.outcome.status == Status::unsupported);
    CHECK(it.outcome.reason.find("t = 0.015343") != std::string::npos);
    CHECK(it.outcome.reason.find("singular configuration (Painleve)") != std::string::npos);
    double before = energy(it.samples[0], coin, g);
    for (const Sample& sample : it.samples) {
      CHECK(energy(sample, coin, g) <= before * (1 + 1e-9));
      before = energy(sample, coin, g);
    }
  }
}

// A board on one edge, two contacts that share a force: steps of equal length reach over the singular configuration,
// and their stages have the forces of its far side. Scenes found by a search in which a stage's slip reversed.
TEST_CASE("a board that slides on its edge towards the singular configuration gains no energy") {
  struct Slid {
    double degrees, friction, restitution, speed, spin, half_width, half_thickness, heading;
  };
  const Slid found[] = {
      {81.475085388410434, 3.0598005205197225, 0.076112262581015208, -0.55267917476426076, 1.8381720046614225,
       0.078726956267980167, 0.019249486174933061, 4.0135555512286922},
      {50.156025791255445, 1.3895025821305185, 0.89754318946412548, -2.7419242902668346, -1.7048640060765088,
       0.17274248877061751, 0.0070646539949038543, 1.0158583951506974},
      {82.2620710157274, 3.6264278240996499, 0.76926141908907697, -1.9054344989348926, -0.119805987802303,
       0.15733265878961966, 0.022926638011585076, 3.6327830750329997},
  };
  for (const Slid& of : found)
    for (const char* law : {"poisson", "stronge"})
      for (const char* method : {"heun", "rk4", "midpoint", "dop853:1e-10"})
        for (const double further : {-1e-3, 0., 1e-3}) {
          const double theta = of.degrees * M_PI / 180, c = std::cos(theta), s = std::sin(theta),
                       lean = M_PI / 2 - theta;
          const double up = half_m * s + of.half_thickness * c, ahead = half_m * c - of.half_thickness * s;
          const double vx = of.speed + of.spin * up, hx = std::cos(of.heading), hy = std::sin(of.heading);
          Scene scene = world({0, 0, -g}, of.restitution, of.friction + further);
          Body board = box("rod", mass_kg, {of.half_thickness, of.half_width, half_m}, {0, 0, up},
                           {vx * hx, vx * hy, -of.spin * ahead});
          const double cl = std::cos(lean / 2), sl = std::sin(lean / 2), ch = std::cos(of.heading / 2),
                       sh = std::sin(of.heading / 2);
          board.orientation_wxyz = {ch * cl, -sh * sl, ch * sl, sh * cl};
          board.angular_velocity_body_rad_per_s = {0, of.spin, 0};
          scene.bodies = {fixed("floor", Plane{{0, 0, 1}, 0}), board};
          const Recorded it =
              try_run(std::string("atwood/") + method + "+event{restitution=" + law + "}", scene, {0.05, 10, 10});
          INFO(method << " " << law << " " << of.degrees << " deg, mu " << of.friction << ": " << it.outcome.reason);
          REQUIRE(it.samples.size() >= 2);
          double before = energy(it.samples[0], board, g);
          for (const Sample& sample : it.samples) {
            CHECK(energy(sample, board, g) <= before * (1 + 1e-4));
            before = energy(sample, board, g);
          }
        }
}

// ATWOOD_PAINLEVE_SEEDS is how many configurations are tried.
TEST_CASE("rods and boards in random configurations neither penetrate the floor nor gain energy") {
  const char* asked = std::getenv("ATWOOD_PAINLEVE_SEEDS");
  const int seeds = asked != nullptr ? std::atoi(asked) : 100;
  int answered = 0, impacts = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const RandomSlide of = random_slide(seed);
    for (const char* law : {"poisson", "stronge"})
      for (const char* method : {"rk4", "dop853:1e-10"}) {
        const Recorded it =
            try_run(std::string("atwood/") + method + "+event{restitution=" + law + "}", of.scene, {0.5, 100, 100});
        INFO("seed " << seed << ", " << method << ", " << law << ": " << it.outcome.reason);
        answered += it.outcome.status == Status::ok;
        impacts += it.count(EventKind::impact);
        CHECK((it.outcome.status == Status::ok || it.outcome.status == Status::unsupported));
        const double scale = energy(it.samples[0], of.scene.bodies[1], g);
        double before = scale;
        for (const Sample& sample : it.samples) {
          const double now = energy(sample, of.scene.bodies[1], g);
          CHECK(now <= before + 1e-9 * scale);
          CHECK(lowest(sample, of) >= -1e-10);
          before = now;
        }
      }
  }
  CHECK(answered > 3.9 * seeds);
  CHECK(impacts > seeds);
}

// Stages of an implicit step beyond the singular configuration have forces of other signs: their equations may have no
// solution, although a shorter step's have one. Of seed 116 both corners of the edge touch while the slip dies out, and
// each one's impact lifts the other. ATWOOD_PAINLEVE_SEEDS is how many configurations are tried.
TEST_CASE("implicit methods step through rods and boards in random configurations, or refuse them by name") {
  const char* asked = std::getenv("ATWOOD_PAINLEVE_SEEDS");
  const int seeds = asked != nullptr ? std::atoi(asked) : 20;
  int answered = 0, runs = 0;
  const auto judge = [&](int seed, const std::string& method, const RandomSlide& of, int steps) {
    const Recorded it = try_run("atwood/" + method, of.scene, {0.5, steps, steps});
    INFO("seed " << seed << ", " << method << ", " << steps << ": " << it.outcome.reason);
    ++runs;
    answered += it.outcome.status == Status::ok;
    CHECK((it.outcome.status == Status::ok || it.outcome.status == Status::unsupported));
    if (it.outcome.status != Status::ok) CHECK(it.outcome.reason.find("at t = ") != std::string::npos);
    const double scale = energy(it.samples[0], of.scene.bodies[1], g);
    for (const Sample& sample : it.samples) {
      CHECK(lowest(sample, of) >= -1e-8);
      CHECK(energy(sample, of.scene.bodies[1], g) <= scale * (1 + 1e-2));
    }
  };
  for (int seed = 0; seed < seeds; ++seed) {
    const RandomSlide of = random_slide(seed);
    for (const char* law : {"newton", "stronge"})
      for (const char* method : {"implicit-midpoint", "gauss4", "gauss6", "radau5", "sdirk4", "bdf2", "radau5:1e-8"})
        for (const int steps : {20, 100})
          judge(seed, std::string(method) + "+event{restitution=" + law + "}", of, steps);
  }
  CHECK(answered > runs / 2);
  for (const char* method : {"rk4", "gauss4", "sdirk4"})
    judge(116, std::string(method) + "+event{restitution=stronge}", random_slide(116), 100);
}
