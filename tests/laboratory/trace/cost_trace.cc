#include "tests/laboratory/trace/cost_trace.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine_client/cli/io/whole_file.h"
#include "engine_client/math/hash.h"
#include "engine_client/telemetry/proto_conversion.h"
#include "tests/laboratory/trace/costs.pb.h"

namespace sweepstake::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "SWPCOSTS";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderBytes = 32;

std::string ErrorOfArms(const std::vector<TracedArm>& arms) {
  if (arms.empty() || arms.size() > kMaxTracedArms) {
    return "has " + std::to_string(arms.size()) + " arms, not 1 to " +
           std::to_string(kMaxTracedArms);
  }
  for (size_t i = 0; i < arms.size(); ++i) {
    const std::string& name = arms[i].name;
    constexpr size_t kMaxLetters = 64;
    const bool printable =
        std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
    if (name.empty() || name.size() > kMaxLetters || !printable) return "has an arm without a name";
    for (size_t j = 0; j < i; ++j) {
      if (arms[j].name == name) return "has the arm " + name + " twice";
    }
  }
  return "";
}

bool IsOneShortLine(const std::string& text) {
  constexpr size_t kMaxBytes = 1000;
  return text.size() <= kMaxBytes && std::none_of(text.begin(), text.end(), [](unsigned char c) {
           return c < ' ' || c == 0x7F;
         });
}

std::string ErrorOfCounts(const CostTrace& trace) {
  if (trace.frame_count == 0 || trace.frame_count > kMaxTracedFrames) {
    return "has " + std::to_string(trace.frame_count) + " frames, not 1 to " +
           std::to_string(kMaxTracedFrames);
  }
  if (!IsOneShortLine(trace.scene) || !IsOneShortLine(trace.machine)) {
    return "has a scene or machine name that is not one line of at most 1000 bytes";
  }
  if (trace.repeat_count == 0) return "was measured in 0 runs";
  if (trace.control_arm >= trace.arms.size()) return "has a control arm with an index out of range";
  if (trace.burst_frame_count < 2 || trace.burst_frame_count > kMaxBurstFrames) {
    return "has bursts of " + std::to_string(trace.burst_frame_count) + " frames, not 2 to " +
           std::to_string(kMaxBurstFrames);
  }
  return "";
}

std::string ErrorOfTimes(const std::string& column, std::span<const uint64_t> times, size_t count) {
  if (times.size() != count) return "has a column " + column + " with the wrong length";
  const bool valid = std::all_of(times.begin(), times.end(),
                                 [](uint64_t ns) { return ns >= 1 && ns <= kMaxTracedNs; });
  return valid ? "" : "has a time of nothing or of more than an hour in its column " + column;
}

std::string ErrorOfColumns(const CostTrace& trace) {
  const size_t frames = trace.frame_count;
  const size_t all = frames * trace.arms.size();
  const std::pair<const char*, bool> lengths[] = {
      {"object_count", trace.object_count.size() == frames},
      {"pair_count", trace.pair_count.size() == frames},
      {"step_ns", trace.step_ns.size() == frames},
      {"aabb_check_count", trace.aabb_check_count.size() == all},
      {"native_bytes", trace.native_bytes.size() == all},
      {"held", trace.held.size() == all},
  };
  for (const auto& [column, fits] : lengths) {
    if (!fits) return std::string("has a column ") + column + " with the wrong length";
  }
  if (std::any_of(trace.held.begin(), trace.held.end(), [](uint8_t held) { return held > 1; })) {
    return "has a column held with other values than 0 and 1";
  }
  if (std::string error = ErrorOfTimes("control_ns", trace.control_ns, frames); !error.empty()) {
    return error;
  }
  return ErrorOfTimes("detection_ns", trace.detection_ns, all);
}

std::string ErrorOfBursts(const CostTrace& trace) {
  if (trace.bursts.empty()) return "has no burst";
  const uint32_t length = trace.burst_frame_count;
  uint64_t free_from = 0;
  for (const TraceBurst& burst : trace.bursts) {
    if (burst.first_frame < free_from || burst.first_frame + uint64_t{length} > trace.frame_count) {
      return "has a burst out of order or beyond its frames";
    }
    free_from = burst.first_frame + uint64_t{1};
    if (std::string error =
            ErrorOfTimes("detection_ns of a burst", burst.detection_ns, length * trace.arms.size());
        !error.empty()) {
      return error;
    }
  }
  return "";
}

bool IsFinite(const SceneDescriptor& descriptor) {
  const float fields[] = {descriptor.object_count, descriptor.density_ratio,
                          descriptor.size_spread,  descriptor.speed_mean,
                          descriptor.speed_spread, descriptor.clustering_ratio,
                          descriptor.static_ratio};
  return std::all_of(std::begin(fields), std::end(fields),
                     [](float value) { return std::isfinite(value); });
}

std::string ErrorOfDescriptors(const CostTrace& trace) {
  uint32_t last = 0;
  for (const TracedDescriptor& traced : trace.descriptors) {
    if (traced.frame < last || traced.frame > trace.frame_count || !IsFinite(traced.descriptor)) {
      return "has a descriptor out of order or with a number that is not finite";
    }
    last = traced.frame;
  }
  return "";
}

template <typename Repeated, typename Number>
void Put(const std::vector<Number>& column, Repeated& repeated) {
  repeated.Assign(column.begin(), column.end());
}

template <typename Number, typename Repeated>
std::vector<Number> Take(const Repeated& repeated) {
  return {repeated.begin(), repeated.end()};
}

void PutColumns(const CostTrace& trace, costs::CostTrace& message) {
  Put(trace.object_count, *message.mutable_object_count());
  Put(trace.pair_count, *message.mutable_pair_count());
  Put(trace.step_ns, *message.mutable_step_ns());
  Put(trace.control_ns, *message.mutable_control_ns());
  Put(trace.detection_ns, *message.mutable_detection_ns());
  Put(trace.aabb_check_count, *message.mutable_aabb_check_count());
  Put(trace.native_bytes, *message.mutable_native_bytes());
  message.set_held(std::string(trace.held.begin(), trace.held.end()));
}

void TakeColumns(const costs::CostTrace& message, CostTrace& trace) {
  trace.object_count = Take<uint32_t>(message.object_count());
  trace.pair_count = Take<uint32_t>(message.pair_count());
  trace.step_ns = Take<uint64_t>(message.step_ns());
  trace.control_ns = Take<uint64_t>(message.control_ns());
  trace.detection_ns = Take<uint64_t>(message.detection_ns());
  trace.aabb_check_count = Take<uint64_t>(message.aabb_check_count());
  trace.native_bytes = Take<uint64_t>(message.native_bytes());
  trace.held = Take<uint8_t>(message.held());
}

costs::CostTrace MessageOf(const CostTrace& trace) {
  costs::CostTrace message;
  message.set_scene(trace.scene);
  message.set_seed(trace.seed);
  message.set_machine(trace.machine);
  message.set_frame_count(trace.frame_count);
  message.set_repeat_count(trace.repeat_count);
  message.set_control_arm(trace.control_arm);
  message.set_burst_frame_count(trace.burst_frame_count);
  for (const TracedArm& arm : trace.arms) {
    costs::TracedArm& wire = *message.add_arms();
    wire.set_name(arm.name);
    wire.set_version(arm.version);
  }
  PutColumns(trace, message);
  for (const TraceBurst& burst : trace.bursts) {
    costs::TraceBurst& wire = *message.add_bursts();
    wire.set_first_frame(burst.first_frame);
    Put(burst.detection_ns, *wire.mutable_detection_ns());
  }
  for (const TracedDescriptor& traced : trace.descriptors) {
    costs::TracedDescriptor& wire = *message.add_descriptors();
    wire.set_frame(traced.frame);
    *wire.mutable_scene_descriptor() = ToProto(traced.descriptor);
  }
  return message;
}

CostTrace TraceOf(const costs::CostTrace& message) {
  CostTrace trace;
  trace.scene = message.scene();
  trace.seed = message.seed();
  trace.machine = message.machine();
  trace.frame_count = message.frame_count();
  trace.repeat_count = message.repeat_count();
  trace.control_arm = message.control_arm();
  trace.burst_frame_count = message.burst_frame_count();
  for (const costs::TracedArm& arm : message.arms()) {
    trace.arms.push_back({arm.name(), arm.version()});
  }
  TakeColumns(message, trace);
  for (const costs::TraceBurst& burst : message.bursts()) {
    trace.bursts.push_back({burst.first_frame(), Take<uint64_t>(burst.detection_ns())});
  }
  for (const costs::TracedDescriptor& traced : message.descriptors()) {
    trace.descriptors.push_back({traced.frame(), FromProto(traced.scene_descriptor())});
  }
  return trace;
}

void AppendNumber(uint64_t number, size_t byte_count, std::string& bytes) {
  for (size_t i = 0; i < byte_count; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xFFU);
}

uint64_t NumberAt(std::string_view bytes, size_t at, size_t byte_count) {
  uint64_t number = 0;
  for (size_t i = 0; i < byte_count; ++i) {
    number |= uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  }
  return number;
}

std::string Header(std::string_view payload) {
  std::string header(kMagic);
  AppendNumber(kVersion, 4, header);
  AppendNumber(0, 4, header);
  AppendNumber(payload.size(), 8, header);
  AppendNumber(math::Fnv1a(math::kFnv1aStart, payload), 8, header);
  return header;
}

Status Broken(const fs::path& path, const std::string& error) {
  return {StatusCode::kDataLoss,
          path.string() + " " + error + "; make it again with `sweepstake-lab trace`"};
}

Result<std::string> ReadBytes(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return Status(StatusCode::kNotFound, "there is no file " + path.string() +
                                             "; `sweepstake-lab trace` makes .costs files");
  }
  const uint64_t size = fs::file_size(path, error);
  if (error || size > kHeaderBytes + kMaxCostsBytes) {
    return Broken(path, "exceeds the maximum size of a cost trace");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file) return Broken(path, "could not be read");
  return bytes;
}

// Returns what is wrong with the file's header, or an empty text.
std::string ErrorOfHeader(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with(kMagic)) return "is not a cost trace";
  const uint64_t version = NumberAt(bytes, 8, 4);
  if (version != kVersion) {
    return "has version " + std::to_string(version) + ", and this program reads " +
           std::to_string(kVersion);
  }
  const std::string_view payload = bytes.substr(kHeaderBytes);
  const uint64_t size = NumberAt(bytes, 16, 8);
  if (NumberAt(bytes, 12, 4) != 0 || size != payload.size()) {
    return "is truncated or has extra bytes: " + std::to_string(payload.size()) + " in place of " +
           std::to_string(size);
  }
  return NumberAt(bytes, 24, 8) == math::Fnv1a(math::kFnv1aStart, payload)
             ? ""
             : "is damaged: its checksum does not match";
}

}  // namespace

std::string ErrorOf(const CostTrace& trace) {
  for (const auto& error_of : {+[](const CostTrace& t) { return ErrorOfArms(t.arms); },
                               ErrorOfCounts, ErrorOfColumns, ErrorOfBursts, ErrorOfDescriptors}) {
    if (std::string error = error_of(trace); !error.empty()) return error;
  }
  return "";
}

Status WriteCosts(const fs::path& path, const CostTrace& trace) {
  assert(ErrorOf(trace).empty());
  const std::string payload = MessageOf(trace).SerializeAsString();
  if (payload.size() > kMaxCostsBytes) {
    return {StatusCode::kResourceExhausted,
            path.string() + " would exceed the maximum size of a cost trace; trace fewer frames"};
  }
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(Header(payload));
  (*file)->Write(payload);
  return (*file)->Commit();
}

Result<CostTrace> ReadCosts(const fs::path& path) {
  const auto bytes = ReadBytes(path);
  if (!bytes.ok()) return bytes.status();
  if (const std::string error = ErrorOfHeader(*bytes); !error.empty()) return Broken(path, error);
  const std::string_view payload = std::string_view(*bytes).substr(kHeaderBytes);
  costs::CostTrace message;
  if (!message.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
    return Broken(path, "holds no readable message");
  }
  CostTrace trace = TraceOf(message);
  if (const std::string error = ErrorOf(trace); !error.empty()) return Broken(path, error);
  return trace;
}

}  // namespace sweepstake::cli
