#include "validation/study/recording_blob.hpp"

#include <algorithm>

#include "validation/metrics/instants.hpp"
#include "validation/study/blob_bytes.hpp"

namespace atwood {
namespace {

static_assert(sizeof(Wide) == 16 && sizeof(double) == 8 && sizeof(ContactSample) == 8 + 11 * 8);  // no padding

using Writer = BlobWriter;
using Reader = BlobReader;

template <class Particle, class Visit> void each_of_particle(Particle& particle, Visit visit) {
  for (auto& value : particle.p_m) visit(value);
  for (auto& value : particle.v_m_per_s) visit(value);
  visit(particle.density_kg_per_m3), visit(particle.pressure_Pa), visit(particle.temperature_K);
}

template <class Joint, class Visit> void each_of_joint(Joint& joint, Visit visit) {
  for (auto& value : joint.q) visit(value);
  for (auto& value : joint.u) visit(value);
  for (auto& value : joint.force_N) visit(value);
  for (auto& value : joint.torque_N_m) visit(value);
  for (auto& value : joint.applied) visit(value);
}

template <class Body, class Visit> void each_value(Body& body, Visit visit) {
  for (auto& value : body.p_m) visit(value);
  for (auto& value : body.q_wxyz) visit(value);
  for (auto& value : body.v_m_per_s) visit(value);
  for (auto& value : body.w_rad_per_s) visit(value);
}

bool is_double(Wide value) { return static_cast<Wide>(static_cast<double>(value)) == value || value != value; }

struct Shape {
  bool doubles = true;  // every number is one
  bool particles = false, joints = false;
  std::size_t bytes = 0;  // about, with 16 a number
};

Shape shape_of(const SampleSeries& samples, std::size_t from, std::size_t to) {
  Shape shape;
  bool& all = shape.doubles;
  for (std::size_t k = from; k < to; ++k) {
    const SampleView sample = samples[k];
    shape.particles = shape.particles || !sample.particles.empty();
    shape.joints = shape.joints || !sample.joints.empty() || !sample.ropes.empty();
    shape.bytes += 64 + sample.bodies.size_bytes() + sample.contacts.size_bytes() + sample.particles.size_bytes() +
                   sample.joints.size_bytes();
    for (const BodySample& body : sample.bodies) each_value(body, [&](Wide value) { all = all && is_double(value); });
    for (const ParticleSample& particle : sample.particles)
      each_of_particle(particle, [&](Wide value) { all = all && is_double(value); });
    for (const JointSample& joint : sample.joints)
      each_of_joint(joint, [&](Wide value) { all = all && is_double(value); });
    for (const RopeSample& rope : sample.ropes) {
      all = all && is_double(rope.tension_N);
      for (const Wide angle : rope.pulley_angle_rad) all = all && is_double(angle);
    }
  }
  return shape;
}

// What the first byte of a recording says: 8 or 16 bytes a number, and what samples have, so that recordings of scenes
// without particles and joints are as they were.
constexpr std::uint8_t kNarrow = 8, kWide = 16, kParticles = 1, kJoints = 2;

void put_joints(Writer& writer, const SampleView& sample, bool narrow) {
  const auto put = [&](Wide value) {
    if (narrow) writer.put(static_cast<double>(value));
    else writer.put(value);
  };
  writer.put(static_cast<std::uint64_t>(sample.joints.size()));
  for (const JointSample& joint : sample.joints) {
    each_of_joint(joint, put);
    writer.put(static_cast<std::uint32_t>(joint.not_unique));
  }
  writer.put(static_cast<std::uint64_t>(sample.ropes.size()));
  for (const RopeSample& rope : sample.ropes) {
    put(rope.tension_N);
    writer.put(static_cast<std::uint64_t>(rope.pulley_angle_rad.size()));
    for (const Wide angle : rope.pulley_angle_rad) put(angle);
  }
}

void read_joints(Reader& reader, Sample& sample, bool narrow) {
  const std::size_t width = narrow ? 8 : 16;
  const auto read = [&](Wide& value) { value = narrow ? static_cast<Wide>(reader.get<double>()) : reader.get<Wide>(); };
  sample.joints.resize(reader.count(16 * width + 4));
  for (JointSample& joint : sample.joints) {
    each_of_joint(joint, read);
    joint.not_unique = reader.get<std::uint32_t>();
  }
  sample.ropes.resize(reader.count(width + 8));
  for (RopeSample& rope : sample.ropes) {
    read(rope.tension_N);
    rope.pulley_angle_rad.resize(reader.count(width));
    for (Wide& angle : rope.pulley_angle_rad) read(angle);
  }
}

}  // namespace

std::string pack_samples(const SampleSeries& samples) { return pack_samples(samples, 0, samples.size()); }

std::string pack_samples(const SampleSeries& samples, std::size_t from, std::size_t to) {
  Writer writer;
  const auto [narrow, particles, joints, bytes] = shape_of(samples, from, to);
  writer.bytes.reserve(bytes);
  writer.put(
      static_cast<std::uint8_t>((narrow ? kNarrow : kWide) | (particles ? kParticles : 0) | (joints ? kJoints : 0)));
  writer.put(static_cast<std::uint64_t>(to - from));
  for (std::size_t k = from; k < to; ++k) {
    const SampleView sample = samples[k];
    writer.put(sample.t_s);
    writer.put(static_cast<std::uint64_t>(sample.bodies.size()));
    for (const BodySample& body : sample.bodies) {
      each_value(body, [&](Wide value) {
        if (narrow) writer.put(static_cast<double>(value));
        else writer.put(value);
      });
    }
    writer.put(static_cast<std::uint64_t>(sample.contacts.size()));
    for (const ContactSample& contact : sample.contacts) writer.put(contact);
    if (joints) put_joints(writer, sample, narrow);
    if (!particles) continue;
    writer.put(static_cast<std::uint64_t>(sample.particles.size()));
    for (const ParticleSample& particle : sample.particles)
      each_of_particle(particle, [&](Wide value) {
        if (narrow) writer.put(static_cast<double>(value));
        else writer.put(value);
      });
  }
  return std::move(writer.bytes);
}

SampleSeries unpack_samples(std::string_view bytes) {
  Reader reader{bytes};
  reader.get<std::uint8_t>();
  const std::size_t count = reader.count(24);
  SampleSeries samples;
  if (count > 0) {
    reader.get<Wide>();  // its time
    const std::size_t bodies = reader.count(13 * 8);
    samples.reserve(std::min(count, 1 + bytes.size() / (24 + 13 * 8 * bodies)), bodies);
  }
  append_samples(bytes, samples);
  return samples;
}

void append_samples(std::string_view bytes, SampleSeries& samples) {
  Reader reader{bytes};
  const auto kind = reader.get<std::uint8_t>();
  const bool narrow = (kind & kWide) == 0, particles = (kind & kParticles) != 0, joints = (kind & kJoints) != 0;
  Sample sample;
  for (std::size_t left = reader.count(24); left > 0; --left) {
    sample.t_s = reader.get<Wide>();
    sample.bodies.resize(reader.count(13 * (narrow ? 8 : 16)));
    for (BodySample& body : sample.bodies) {
      each_value(body,
                 [&](Wide& value) { value = narrow ? static_cast<Wide>(reader.get<double>()) : reader.get<Wide>(); });
    }
    sample.contacts.resize(reader.count(sizeof(ContactSample)));
    for (ContactSample& contact : sample.contacts) contact = reader.get<ContactSample>();
    if (joints) read_joints(reader, sample, narrow);
    if (particles) sample.particles.resize(reader.count(9 * (narrow ? 8 : 16)));
    for (ParticleSample& particle : sample.particles)
      each_of_particle(particle, [&](Wide& value) {
        value = narrow ? static_cast<Wide>(reader.get<double>()) : reader.get<Wide>();
      });
    samples.push_back(sample);
  }
  reader.end();
}

std::string pack_events(const std::vector<Event>& events) {
  Writer writer;
  writer.put(static_cast<std::uint64_t>(events.size()));
  for (const Event& event : events) {
    writer.put(event.t_s);
    writer.put(static_cast<std::int32_t>(event.kind));
    writer.put(static_cast<std::int32_t>(event.body_a));
    writer.put(static_cast<std::int32_t>(event.body_b));
    for (const Wide value : event.x_m) writer.put(value);
    for (const Wide value : event.normal) writer.put(value);
    for (const Wide value :
         {event.impulse_n_N_s, event.impulse_t_N_s, event.vn_before_m_per_s, event.vn_after_m_per_s}) {
      writer.put(value);
    }
  }
  return std::move(writer.bytes);
}

namespace {

std::vector<Event> read_events(Reader& reader) {
  std::vector<Event> events(reader.count(12 + 11 * 16));
  for (Event& event : events) {
    event.t_s = reader.get<Wide>();
    event.kind = static_cast<EventKind>(reader.get<std::int32_t>());
    event.body_a = reader.get<std::int32_t>();
    event.body_b = reader.get<std::int32_t>();
    for (Wide& value : event.x_m) value = reader.get<Wide>();
    for (Wide& value : event.normal) value = reader.get<Wide>();
    for (Wide* value :
         {&event.impulse_n_N_s, &event.impulse_t_N_s, &event.vn_before_m_per_s, &event.vn_after_m_per_s}) {
      *value = reader.get<Wide>();
    }
  }
  return events;
}

}  // namespace

std::vector<Event> unpack_events(std::string_view bytes) {
  Reader reader{bytes};
  std::vector<Event> events = read_events(reader);
  reader.end();
  return events;
}

std::string pack_beside_samples(const Recording& recording, const std::map<std::string, SolveTally>& solvers) {
  Writer writer{pack_events(recording.events)};
  if (solvers.empty() && recording.between.empty()) return std::move(writer.bytes);
  writer.put(static_cast<std::uint64_t>(solvers.size()));
  for (const auto& [name, tally] : solvers) {
    writer.put(static_cast<std::uint64_t>(name.size()));
    writer.bytes += name;
    for (const std::int64_t count : {tally.converged, tally.stagnated, tally.capped, tally.iterations_max})
      writer.put(count);
    writer.put(tally.residual_max);
  }
  if (recording.between.empty()) return std::move(writer.bytes);
  writer.put(recording.shared);
  return std::move(writer.bytes) + pack_samples(recording.between);
}

void unpack_beside_samples(std::string_view bytes, Recording& recording) {
  Reader reader{bytes};
  recording.events = read_events(reader);
  recording.outcome.solvers.clear();
  if (reader.at == bytes.size()) return;
  constexpr std::size_t min_solver = 8 + 5 * 8;
  for (std::size_t left = reader.count(min_solver); left > 0; --left) {
    const std::size_t size = reader.count(1);
    SolveTally& tally = recording.outcome.solvers[std::string(bytes.substr(reader.at, size))];
    reader.at += size;
    for (std::int64_t* count : {&tally.converged, &tally.stagnated, &tally.capped, &tally.iterations_max})
      *count = reader.get<std::int64_t>();
    tally.residual_max = reader.get<double>();
  }
  if (reader.at == bytes.size()) return;
  recording.shared = reader.get<std::int64_t>();
  const auto own = static_cast<std::int64_t>(recording.values.size()) - 1;
  recording.between = unpack_samples(bytes.substr(reader.at));
  std::size_t expected = 0;
  if (may_share(own, recording.shared))
    for (const std::int64_t k : judged_instants(own, recording.shared))
      expected += k % (recording.shared / own) != 0 ? 1 : 0;
  if (expected != recording.between.size())
    throw BadBlob("a stored recording has other instants than its samples share");
}

std::string pack_reals(const std::vector<double>& values) {
  Writer writer;
  writer.put(static_cast<std::uint64_t>(values.size()));
  for (const double value : values) writer.put(value);
  return std::move(writer.bytes);
}

std::vector<double> unpack_reals(std::string_view bytes) {
  Reader reader{bytes};
  std::vector<double> values(reader.count(8));
  for (double& value : values) value = reader.get<double>();
  reader.end();
  return values;
}

std::string pack_series(const Series& series) {
  std::string bytes;
  for (const auto* values : {&series.t_s, &series.position_m, &series.velocity_m_per_s, &series.attitude_rad,
                             &series.body_rate_rad_per_s, &series.energy}) {
    bytes += pack_reals(*values);
  }
  return bytes;
}

namespace {

Series read_series(Reader& reader) {
  Series series;
  for (auto* values : {&series.t_s, &series.position_m, &series.velocity_m_per_s, &series.attitude_rad,
                       &series.body_rate_rad_per_s, &series.energy}) {
    values->resize(reader.count(8));
    for (double& value : *values) value = reader.get<double>();
  }
  return series;
}

// Every list of a picture, and every number.
template <class Picture, class List, class Number> void each_of_picture(Picture& picture, List list, Number number) {
  number(picture.t_s), number(picture.side_m);
  for (std::size_t i = 0; i < 2; ++i) number(picture.low_m[i]), number(picture.high_m[i]);
  for (auto* values : {&picture.x_m, &picture.y_m, &picture.speed_m_per_s, &picture.pressure_Pa, &picture.temperature_K,
                       &picture.error})
    list(*values);
}

}  // namespace

Series unpack_series(std::string_view bytes) {
  Reader reader{bytes};
  Series series = read_series(reader);
  reader.end();
  return series;
}

std::string pack_series_and_picture(const Series& series, const FluidPicture& picture) {
  std::string bytes = pack_series(series);
  if (picture.empty()) return bytes;
  Writer writer;
  writer.put(picture.particles);
  writer.put(static_cast<std::uint64_t>(picture.error_of.size()));
  writer.bytes += picture.error_of;
  each_of_picture(
      picture,
      [&](const std::vector<float>& values) {
        writer.put(static_cast<std::uint64_t>(values.size()));
        for (const float value : values) writer.put(value);
      },
      [&](double value) { writer.put(value); });
  return bytes + writer.bytes;
}

Series unpack_series_and_picture(std::string_view bytes, FluidPicture& picture) {
  Reader reader{bytes};
  Series series = read_series(reader);
  picture = {};
  if (reader.at == bytes.size()) return series;
  picture.particles = reader.get<std::int64_t>();
  picture.error_of.resize(reader.count(1));
  for (char& letter : picture.error_of) letter = reader.get<char>();
  each_of_picture(
      picture,
      [&](std::vector<float>& values) {
        values.resize(reader.count(4));
        for (float& value : values) value = reader.get<float>();
      },
      [&](double& value) { value = reader.get<double>(); });
  const std::size_t count = picture.x_m.size();
  for (const auto* values : {&picture.y_m, &picture.speed_m_per_s, &picture.pressure_Pa})
    if (values->size() != count) throw BadBlob("a stored picture has lists of different lengths");
  for (const auto* values : {&picture.temperature_K, &picture.error})
    if (!values->empty() && values->size() != count) throw BadBlob("a stored picture has lists of different lengths");
  reader.end();
  return series;
}

}  // namespace atwood
