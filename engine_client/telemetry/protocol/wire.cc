#include "engine_client/telemetry/protocol/wire.h"

#include <protozero/pbf_message.hpp>
#include <protozero/pbf_writer.hpp>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine_client/text/names.h"

namespace sweepstake::protocol {
namespace {

using Number = protozero::pbf_tag_type;
using WireType = protozero::pbf_wire_type;

// The fields that contain the reason of an error, from errors.proto and google.protobuf.Any.
struct ErrorInfo {
  std::string reason;
  std::string domain;
};
struct Any {
  std::string type_url;
  std::string value;
};
struct StatusDetails {
  int32_t code = 0;
  std::string message;
  std::vector<Any> details;
};

// Lists the fields of each message, const for messages that are sent. f(n, a, b, …) handles the
// fields with the numbers n, n + 1, … of the proto files. tests/wire_fields_test.py compares names
// and numbers with the proto files.

void Fields(auto& f, const RewardWeights& m) { f(1, m.fps, m.detection, m.memory, m.checks); }
void Fields(auto& f, RewardWeights& m) { f(1, m.fps, m.detection, m.memory, m.checks); }

void Fields(auto& f, const Arm& m) { f(1, m.name, m.backend_version); }

void Fields(auto& f, const Hello& m) {
  f(1, m.protocol_version, m.project, m.scene, m.build, m.machine_class, m.arms, m.active_arm,
    m.mode, m.session_id, m.time_scale, m.ignore_priors, m.seed, m.policy, m.switch_epoch,
    m.resume_token, m.capabilities, m.rules.weights, m.rules.decision_interval_ns,
    m.rules.cooldown_ns, m.rules.settling_ns, m.initial_arm);
}

void Fields(auto& f, const SceneDescriptor& m) {
  f(1, m.object_count, m.density_ratio, m.size_spread, m.speed_mean, m.speed_spread,
    m.clustering_ratio, m.static_ratio);
}

void Fields(auto& f, const ShadowSample& m) {
  f(1, m.first_frame_index, m.arm, m.detection_time_ns, m.build_time_ns, m.aabb_check_count,
    m.native_bytes, m.object_count, m.frame_count, m.flags);
}

void Fields(auto& f, const FrameBatch& m) {
  const uint64_t first_frame_index = m.first_frame_index();
  f.Columns(1, m.frames, &FrameSample::frame_time_ns, &FrameSample::detection_time_ns,
            &FrameSample::aabb_check_count, &FrameSample::native_bytes, &FrameSample::object_count,
            &FrameSample::arm, &FrameSample::switch_epoch, &FrameSample::flags);
  f(9, m.scene_descriptor, m.dropped_frame_count, m.shadow_samples, m.invalid_box_count,
    first_frame_index);
}

void Fields(auto& f, const SwitchOutcome& m) {
  f(1, m.command_id, m.arm, m.switch_epoch, m.executed != 0, m.rebuild_time_ns, m.settling_cost_ns,
    m.reason, m.trial_detection_time_ns, m.trial_arm);
}

void Fields(auto& f, const BailOut& m) {
  f(1, m.frame.frame_index, m.frame.arm, m.frame.switch_epoch, m.frame.frame_time_ns,
    m.frame.detection_time_ns, m.frame.flags);
}

void Fields(auto& f, const ModeChange& m) { f(1, m.mode, m.active_arm, m.order_id); }

void Fields(auto& /*f*/, const Goodbye& /*m*/) {}

void Fields(auto& f, const OrderRefusal& m) { f(1, m.order_id, m.reason); }

void Fields(auto& f, const BoxView& m) {
  f(1, m.frame_index, m.object_count, m.stride, m.bounds, m.boxes, m.pairs);
}

void Fields(auto& f, decision::BetaPosterior& m) { f(1, m.alpha, m.beta); }

void Fields(auto& f, Welcome& m) {
  f(1, m.session_id, m.resumed, m.acknowledged_sequence, m.max_batch_frames, m.max_message_bytes,
    m.batch_interval_ms, m.decision_interval_ms, m.settling_ms, m.bail_out_ms, m.daemon_version,
    m.policy, m.seed, m.priors, m.prior_source_count, m.resume_token, m.priors_unavailable,
    m.capabilities, m.cooldown_ms, m.weights);
}

void Fields(auto& f, SwitchCommand& m) {
  f(1, m.command_id, m.arm, m.reason, m.trial_limit_percent);
}

void Fields(auto& f, Acknowledgement& m) { f(1, m.sequence, m.batch_interval_ms); }

void Fields(auto& f, CostRatio& m) { f(1, m.median, m.low, m.high); }

void Fields(auto& f, ArmStanding& m) {
  f(1, m.live_window_count, m.lane_visit_count, m.effective_window_count, m.best_probability,
    m.cost_ratio);
}

void Fields(auto& f, PosteriorSnapshot& m) {
  f(1, m.arms, m.verdict.verdict, m.verdict.leader_arm, m.verdict.leader_probability, m.standings,
    m.saved_us);
}

void Fields(auto& f, Reconnect& m) { f(1, m.delay_ms); }

void Fields(auto& f, OperatorOrder& m) { f(1, m.order_id, m.mode, m.arm); }

void Fields(auto& f, BoxRequest& m) { f(1, m.interval_ms, m.max_bytes, m.until_ms); }

void Fields(auto& f, Response& m) {
  f(1, m.welcome, m.switch_command, m.acknowledgement, m.posterior_snapshot, m.reconnect,
    m.operator_order, m.box_request);
}

void Fields(auto& f, ErrorInfo& m) { f(1, m.reason, m.domain); }

void Fields(auto& f, Any& m) { f(1, m.type_url, m.value); }

void Fields(auto& f, StatusDetails& m) { f(1, m.code, m.message, m.details); }

template <typename Value>
constexpr bool kIsVarint = std::is_integral_v<Value> || std::is_enum_v<Value>;

// Writes a message. Leaves out values that are the default, as proto3 does. A nested message is
// written even if it is empty.
class Writer {
 public:
  template <typename... Values>
  void operator()(Number first, const Values&... values) {
    (Put(first++, values), ...);
  }
  // Writes one packed field per member, which holds that member of all frames.
  template <typename... Members>
  void Columns(Number first, const std::vector<FrameSample>& frames,
               Members FrameSample::*... members) {
    (Pack(first++, frames, [&](const FrameSample& frame) { return frame.*members; }), ...);
  }

  std::string Take() { return std::move(bytes_); }

 private:
  template <typename Value>
  void Put(Number number, const Value& value) {
    if constexpr (kIsVarint<Value>) {
      if (static_cast<uint64_t>(value) != 0)
        writer_.add_uint64(number, static_cast<uint64_t>(value));
    } else if constexpr (std::is_same_v<Value, double>) {
      if (value != 0) writer_.add_double(number, value);
    } else if constexpr (std::is_same_v<Value, float>) {
      if (value >= 0) writer_.add_float(number, value);  // a negative value was not measured
    } else if constexpr (std::is_same_v<Value, std::string>) {
      if (!value.empty()) writer_.add_bytes(number, value);
    } else {
      Writer inner;
      Fields(inner, value);
      writer_.add_message(number, inner.bytes_);
    }
  }
  template <typename Value>
  void Put(Number number, const std::optional<Value>& value) {
    if (!value) return;
    if constexpr (kIsVarint<Value>) {
      writer_.add_uint64(number, static_cast<uint64_t>(*value));  // 0 differs from absent
    } else {
      Put(number, *value);
    }
  }
  // Writes a list of numbers as a packed field.
  template <typename Value>
  void Put(Number number, const std::vector<Value>& values) {
    if constexpr (std::is_same_v<Value, float>) {
      writer_.add_packed_float(number, values.begin(), values.end());
    } else if constexpr (kIsVarint<Value>) {
      Pack(number, values, [](const Value& value) { return static_cast<uint64_t>(value); });
    } else {
      for (const Value& value : values) Put(number, value);
    }
  }
  template <typename Value, typename NumberOf>
  void Pack(Number number, const std::vector<Value>& values, const NumberOf& number_of) {
    if (values.empty()) return;
    protozero::packed_field_uint64 column(writer_, number);
    for (const Value& value : values) column.add_element(number_of(value));
  }

  std::string bytes_;
  protozero::pbf_writer writer_{bytes_};
};

// Returns a message in which all values are 0, as before any field is received. (The structs' own
// defaults can differ from 0.)
template <typename Message>
Message Absent() {
  if constexpr (std::is_same_v<Message, SwitchCommand>) return {.reason = SwitchReason{}};
  if constexpr (std::is_same_v<Message, OperatorOrder>) return {.mode = Mode{}, .arm = {}};
  if constexpr (std::is_same_v<Message, decision::BetaPosterior>) return {.alpha = 0, .beta = 0};
  if constexpr (std::is_same_v<Message, RewardWeights>)
    return {.fps = 0, .detection = 0, .memory = 0, .checks = 0};
  if constexpr (std::is_same_v<Message, CostRatio>) return {.median = 0, .low = 0, .high = 0};
  return {};
}

// Reads a message as protobuf does. Fields may come in any order. If a field occurs twice, the
// later value replaces the earlier one; nested messages are merged. A field that is encoded as
// another type counts as unknown.
class Reader {
 public:
  // Reads the message. Returns whether it had an unknown field.
  template <typename Message>
  static bool Read(std::string_view bytes, Message& message) {
    Reader reader(bytes);
    bool has_unknown = false;
    while (reader.in_.next()) {
      reader.taken_ = false;
      Fields(reader, message);
      if (reader.taken_) continue;
      reader.in_.skip();
      has_unknown = true;
    }
    return has_unknown;
  }

  template <typename... Values>
  void operator()(Number first, Values&... values) {
    (TakeIf(first++ == in_.tag(), values), ...);
  }

 private:
  explicit Reader(std::string_view bytes) : in_(bytes.data(), bytes.size()) {}

  template <typename Value>
  void TakeIf(bool is_next, Value& value) {
    if (is_next && !taken_) taken_ = Take(value);
  }

  bool Is(WireType type) const { return in_.wire_type() == type; }
  std::string_view View() {
    const protozero::data_view view = in_.get_view();
    return {view.data(), view.size()};
  }

  // Reads the value of the current field. Returns false and reads nothing if it is encoded as
  // another type.
  template <typename Value>
  bool Take(Value& value) {
    if constexpr (kIsVarint<Value>) {
      if (!Is(WireType::varint)) return false;
      // An enumeration may hold a value that only a newer protocol defines.
      // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange)
      value = static_cast<Value>(in_.get_uint64());
    } else if constexpr (std::is_same_v<Value, double>) {
      if (!Is(WireType::fixed64)) return false;
      value = in_.get_double();
    } else {
      if (!Is(WireType::length_delimited)) return false;
      if constexpr (std::is_same_v<Value, std::string>) {
        value = View();
      } else {
        Read(View(), value);
      }
    }
    return true;
  }
  template <typename Value>
  bool Take(std::optional<Value>& value) {
    Value read = value ? std::move(*value) : Absent<Value>();
    const bool is_taken = Take(read);
    if (is_taken || value) value = std::move(read);
    return is_taken;
  }
  // Reads numbers that are packed or come one by one.
  template <typename Value>
  bool Take(std::vector<Value>& values) {
    if constexpr (kIsVarint<Value>) {
      if (Is(WireType::length_delimited)) {
        for (const uint64_t number : in_.get_packed_uint64())
          values.push_back(static_cast<Value>(number));
        return true;
      }
    }
    Value value = Absent<Value>();
    if (!Take(value)) return false;
    values.push_back(std::move(value));
    return true;
  }

  protozero::pbf_reader in_;
  bool taken_ = false;
};

// Returns a StreamTelemetryRequest that contains this message.
template <typename Message>
std::string Request(Number number, const Message& message) {
  Writer writer;
  writer(number, message);
  return writer.Take();
}

bool HasTextsOfALine(const Welcome& welcome) {
  return text::IsLine(welcome.session_id) && text::IsLine(welcome.daemon_version) &&
         text::IsLine(welcome.policy);
}

// Returns the reason in the detail; empty if the detail is not an ErrorInfo.
std::string ReasonIn(const Any& detail) {
  if (detail.type_url != "type.googleapis.com/google.rpc.ErrorInfo") return "";
  ErrorInfo info;
  Reader::Read(detail.value, info);
  return info.domain == "sweepstake" && text::IsName(info.reason) ? info.reason : "";
}

}  // namespace

std::string Encode(const Hello& hello) { return Request(2, hello); }
std::string Encode(const FrameBatch& batch) { return Request(3, batch); }
std::string Encode(const SwitchOutcome& outcome) { return Request(4, outcome); }
std::string Encode(const BailOut& bail_out) { return Request(5, bail_out); }
std::string Encode(const ModeChange& change) { return Request(6, change); }
std::string Encode(const Goodbye& goodbye) { return Request(7, goodbye); }
std::string Encode(const OrderRefusal& refusal) { return Request(8, refusal); }
std::string Encode(const BoxView& view) { return Request(9, view); }

std::string Numbered(uint64_t sequence, std::string_view encoded) {
  return Request(1, sequence).append(encoded);
}

std::optional<Response> DecodeResponse(std::string_view bytes) {
  try {
    Response response;
    response.has_unknown = Reader::Read(bytes, response);
    if (response.welcome && !HasTextsOfALine(*response.welcome)) return std::nullopt;
    return response;
  } catch (const protozero::exception&) {
    return std::nullopt;
  }
}

std::optional<DaemonStatus> StatusIn(std::string_view status_details) {
  constexpr int32_t kLastCode = 16;  // UNAUTHENTICATED
  try {
    StatusDetails status;
    Reader::Read(status_details, status);
    if (status.code < 1 || status.code > kLastCode) return std::nullopt;
    for (const Any& detail : status.details) {
      if (std::string reason = ReasonIn(detail); !reason.empty())
        return DaemonStatus{static_cast<uint32_t>(status.code), std::move(status.message),
                            std::move(reason)};
    }
    return std::nullopt;
  } catch (const protozero::exception&) {
    return std::nullopt;
  }
}

}  // namespace sweepstake::protocol
