// Decodes messages. The tags are the field numbers of telemetry.proto and errors.proto.
// tests/wire_fields_test.py checks that the code reads each field by the name of its tag.
#include <protozero/pbf_message.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/telemetry/protocol/wire.h"
#include "engine_client/text/names.h"

namespace sweepstake::protocol {
namespace {

using protozero::pbf_message;
using protozero::pbf_wire_type;
using Number = protozero::pbf_tag_type;

enum class StreamTelemetryResponseTag : Number {
  kWelcome = 1,
  kSwitchCommand = 2,
  kAcknowledgement = 3,
  kPosteriorSnapshot = 4,
  kReconnect = 5,
  kOperatorOrder = 6,
  kBoxRequest = 7
};
enum class WelcomeTag : Number {
  kSessionId = 1,
  kResumed = 2,
  kAcknowledgedSequence = 3,
  kMaxBatchFrames = 4,
  kMaxMessageBytes = 5,
  kBatchIntervalMs = 6,
  kDecisionIntervalMs = 7,
  kSettlingMs = 8,
  kBailOutMs = 9,
  kDaemonVersion = 10,
  kPolicy = 11,
  kSeed = 12,
  kPriors = 13,
  kPriorSourceCount = 14,
  kResumeToken = 15,
  kPriorsUnavailable = 16,
  kCapabilities = 17
};
enum class BetaPosteriorTag : Number { kAlpha = 1, kBeta = 2 };
enum class SwitchCommandTag : Number {
  kCommandId = 1,
  kArm = 2,
  kReason = 3,
  kTrialLimitPercent = 4
};
enum class AcknowledgementTag : Number { kSequence = 1, kBatchIntervalMs = 2 };
enum class PosteriorSnapshotTag : Number {
  kArms = 1,
  kVerdict = 2,
  kLeaderArm = 3,
  kLeaderProbability = 4,
  kStandings = 5
};
enum class ArmStandingTag : Number {
  kLiveWindowCount = 1,
  kLaneVisitCount = 2,
  kEffectiveWindowCount = 3,
  kBestProbability = 4,
  kCostRatio = 5
};
enum class CostRatioTag : Number { kMedian = 1, kLow = 2, kHigh = 3 };
enum class ReconnectTag : Number { kDelayMs = 1 };
enum class OperatorOrderTag : Number { kOrderId = 1, kMode = 2, kArm = 3 };
enum class BoxRequestTag : Number { kIntervalMs = 1, kMaxBytes = 2, kUntilMs = 3 };

enum class StatusDetailsTag : Number { kDetails = 3 };
enum class AnyTag : Number { kTypeUrl = 1, kValue = 2 };
enum class ErrorInfoTag : Number { kReason = 1, kDomain = 2 };

// The Read functions follow protobuf's rules. Fields may come in any order. If a field comes twice,
// the last value wins, and messages are merged. A field with the wire type of another type is
// unknown.
template <typename Tag>
class Reader {
 public:
  explicit Reader(std::string_view bytes) : message_(bytes.data(), bytes.size()) {}

  bool Next() { return message_.next(); }
  Tag tag() const { return message_.tag(); }
  void Skip() {
    message_.skip();
    has_unknown_ = true;
  }
  bool has_unknown() const { return has_unknown_; }

  // Reads an integer, an enumeration or a bool.
  template <typename Value>
  void TakeNumber(Value& value) {
    if (!Is(pbf_wire_type::varint)) return Skip();
    const uint64_t number = message_.get_uint64();
    // An enumeration may hold a value that only a newer protocol defines.
    // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange)
    value = static_cast<Value>(number);
  }
  void TakeDouble(double& value) {
    if (!Is(pbf_wire_type::fixed64)) return Skip();
    value = message_.get_double();
  }
  void TakeText(std::string& text) {
    if (!Is(pbf_wire_type::length_delimited)) return Skip();
    text = message_.get_string();
  }
  // Calls `read` with the bytes of a message.
  template <typename Read>
  void TakeMessage(const Read& read) {
    if (!Is(pbf_wire_type::length_delimited)) return Skip();
    const protozero::data_view view = message_.get_view();
    read(std::string_view(view.data(), view.size()));
  }
  template <typename Value>
  void TakeNumber(std::optional<Value>& value) {
    if (!Is(pbf_wire_type::varint)) return Skip();
    TakeNumber(value.emplace());
  }
  // Reads repeated numbers, which are encoded one by one or packed.
  template <typename Value>
  void TakeNumbers(std::vector<Value>& values) {
    if (Is(pbf_wire_type::varint))
      values.push_back(static_cast<Value>(message_.get_uint64()));
    else if (Is(pbf_wire_type::length_delimited)) {
      for (const uint64_t number : message_.get_packed_uint64())
        values.push_back(static_cast<Value>(number));
    } else
      Skip();
  }

 private:
  bool Is(pbf_wire_type type) const { return message_.wire_type() == type; }

  pbf_message<Tag> message_;
  bool has_unknown_ = false;
};

// Calls `take` for each field. Returns whether any field was unknown.
template <typename Tag, typename Take>
bool ReadFields(std::string_view bytes, const Take& take) {
  Reader<Tag> in(bytes);
  while (in.Next()) take(in);
  return in.has_unknown();
}

BetaPosterior ReadPosterior(std::string_view bytes) {
  BetaPosterior posterior;
  ReadFields<BetaPosteriorTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case BetaPosteriorTag::kAlpha:
        return in.TakeDouble(posterior.alpha);
      case BetaPosteriorTag::kBeta:
        return in.TakeDouble(posterior.beta);
      default:
        in.Skip();
    }
  });
  return posterior;
}

template <typename Tag>
void TakePosterior(Reader<Tag>& in, std::vector<BetaPosterior>& posteriors) {
  in.TakeMessage([&](std::string_view bytes) { posteriors.push_back(ReadPosterior(bytes)); });
}

void Read(std::string_view bytes, Welcome& welcome) {
  ReadFields<WelcomeTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case WelcomeTag::kSessionId:
        return in.TakeText(welcome.session_id);
      case WelcomeTag::kResumed:
        return in.TakeNumber(welcome.resumed);
      case WelcomeTag::kAcknowledgedSequence:
        return in.TakeNumber(welcome.acknowledged_sequence);
      case WelcomeTag::kDaemonVersion:
        return in.TakeText(welcome.daemon_version);
      case WelcomeTag::kPolicy:
        return in.TakeText(welcome.policy);
      case WelcomeTag::kSeed:
        return in.TakeNumber(welcome.seed);
      case WelcomeTag::kResumeToken:
        return in.TakeText(welcome.resume_token);
      case WelcomeTag::kCapabilities:
        return in.TakeNumbers(welcome.capabilities);
      case WelcomeTag::kMaxBatchFrames:
        return in.TakeNumber(welcome.max_batch_frames);
      case WelcomeTag::kMaxMessageBytes:
        return in.TakeNumber(welcome.max_message_bytes);
      case WelcomeTag::kBatchIntervalMs:
        return in.TakeNumber(welcome.batch_interval_ms);
      case WelcomeTag::kDecisionIntervalMs:
        return in.TakeNumber(welcome.decision_interval_ms);
      case WelcomeTag::kSettlingMs:
        return in.TakeNumber(welcome.settling_ms);
      case WelcomeTag::kBailOutMs:
        return in.TakeNumber(welcome.bail_out_ms);
      case WelcomeTag::kPriors:
        return TakePosterior(in, welcome.priors);
      case WelcomeTag::kPriorSourceCount:
        return in.TakeNumber(welcome.prior_source_count);
      case WelcomeTag::kPriorsUnavailable:
        return in.TakeNumber(welcome.priors_unavailable);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, SwitchCommand& command) {
  ReadFields<SwitchCommandTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case SwitchCommandTag::kCommandId:
        return in.TakeNumber(command.command_id);
      case SwitchCommandTag::kArm:
        return in.TakeNumber(command.arm);
      case SwitchCommandTag::kReason:
        return in.TakeNumber(command.reason);
      case SwitchCommandTag::kTrialLimitPercent:
        return in.TakeNumber(command.trial_limit_percent);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, Acknowledgement& acknowledgement) {
  ReadFields<AcknowledgementTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case AcknowledgementTag::kSequence:
        return in.TakeNumber(acknowledgement.sequence);
      case AcknowledgementTag::kBatchIntervalMs:
        return in.TakeNumber(acknowledgement.batch_interval_ms);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, CostRatio& ratio) {
  ReadFields<CostRatioTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case CostRatioTag::kMedian:
        return in.TakeDouble(ratio.median);
      case CostRatioTag::kLow:
        return in.TakeDouble(ratio.low);
      case CostRatioTag::kHigh:
        return in.TakeDouble(ratio.high);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, ArmStanding& standing) {
  ReadFields<ArmStandingTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case ArmStandingTag::kLiveWindowCount:
        return in.TakeNumber(standing.live_window_count);
      case ArmStandingTag::kLaneVisitCount:
        return in.TakeNumber(standing.lane_visit_count);
      case ArmStandingTag::kEffectiveWindowCount:
        return in.TakeDouble(standing.effective_window_count);
      case ArmStandingTag::kBestProbability:
        return in.TakeDouble(standing.best_probability);
      case ArmStandingTag::kCostRatio:
        // Protobuf omits fields that are 0, so absent fields are 0 here too.
        return in.TakeMessage([&](std::string_view ratio) {
          if (!standing.cost_ratio)
            standing.cost_ratio = CostRatio{.median = 0, .low = 0, .high = 0};
          Read(ratio, *standing.cost_ratio);
        });
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, PosteriorSnapshot& snapshot) {
  ReadFields<PosteriorSnapshotTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case PosteriorSnapshotTag::kArms:
        return TakePosterior(in, snapshot.arms);
      case PosteriorSnapshotTag::kVerdict:
        return in.TakeNumber(snapshot.verdict.verdict);
      case PosteriorSnapshotTag::kLeaderArm:
        return in.TakeNumber(snapshot.verdict.leader_arm);
      case PosteriorSnapshotTag::kLeaderProbability:
        return in.TakeDouble(snapshot.verdict.leader_probability);
      case PosteriorSnapshotTag::kStandings:
        return in.TakeMessage(
            [&](std::string_view standing) { Read(standing, snapshot.standings.emplace_back()); });
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, Reconnect& reconnect) {
  ReadFields<ReconnectTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case ReconnectTag::kDelayMs:
        return in.TakeNumber(reconnect.delay_ms);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, OperatorOrder& order) {
  ReadFields<OperatorOrderTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case OperatorOrderTag::kOrderId:
        return in.TakeNumber(order.order_id);
      case OperatorOrderTag::kMode:
        return in.TakeNumber(order.mode);
      case OperatorOrderTag::kArm:
        return in.TakeNumber(order.arm);
      default:
        in.Skip();
    }
  });
}

void Read(std::string_view bytes, BoxRequest& request) {
  ReadFields<BoxRequestTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case BoxRequestTag::kIntervalMs:
        return in.TakeNumber(request.interval_ms);
      case BoxRequestTag::kMaxBytes:
        return in.TakeNumber(request.max_bytes);
      case BoxRequestTag::kUntilMs:
        return in.TakeNumber(request.until_ms);
      default:
        in.Skip();
    }
  });
}

// Reads a message into `part`. If the response has no such part yet, it starts as `absent`.
template <typename Part>
void TakePart(Reader<StreamTelemetryResponseTag>& in, std::optional<Part>& part, Part absent = {}) {
  in.TakeMessage([&](std::string_view bytes) {
    if (!part) part = std::move(absent);
    Read(bytes, *part);
  });
}

Response ReadResponse(std::string_view bytes) {
  Response response;
  response.has_unknown = ReadFields<StreamTelemetryResponseTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case StreamTelemetryResponseTag::kWelcome:
        return TakePart(in, response.welcome);
      case StreamTelemetryResponseTag::kSwitchCommand:
        return TakePart(in, response.switch_command, {.reason = SwitchReason{}});
      case StreamTelemetryResponseTag::kAcknowledgement:
        return TakePart(in, response.acknowledgement);
      case StreamTelemetryResponseTag::kPosteriorSnapshot:
        return TakePart(in, response.posterior_snapshot);
      case StreamTelemetryResponseTag::kReconnect:
        return TakePart(in, response.reconnect);
      case StreamTelemetryResponseTag::kOperatorOrder:
        return TakePart(in, response.operator_order, {.mode = Mode{}, .arm = {}});
      case StreamTelemetryResponseTag::kBoxRequest:
        return TakePart(in, response.box_request);
      default:
        in.Skip();
    }
  });
  return response;
}

bool HasTextsOfALine(const Welcome& welcome) {
  return text::IsLine(welcome.session_id) && text::IsLine(welcome.daemon_version) &&
         text::IsLine(welcome.policy);
}

struct ErrorInfo {
  std::string reason;
  std::string domain;
};

void Read(std::string_view bytes, ErrorInfo& info) {
  ReadFields<ErrorInfoTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case ErrorInfoTag::kReason:
        return in.TakeText(info.reason);
      case ErrorInfoTag::kDomain:
        return in.TakeText(info.domain);
      default:
        in.Skip();
    }
  });
}

// Returns the error reason in a google.protobuf.Any; empty if it contains another message.
std::string ReasonInDetail(std::string_view bytes) {
  std::string type_url;
  std::string value;
  ReadFields<AnyTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case AnyTag::kTypeUrl:
        return in.TakeText(type_url);
      case AnyTag::kValue:
        return in.TakeText(value);
      default:
        in.Skip();
    }
  });
  if (type_url != "type.googleapis.com/google.rpc.ErrorInfo") return "";
  ErrorInfo info;
  Read(value, info);
  return info.domain == "sweepstake" && text::IsName(info.reason) ? info.reason : "";
}

std::string ReasonInDetails(std::string_view bytes) {
  std::string reason;
  ReadFields<StatusDetailsTag>(bytes, [&](auto& in) {
    switch (in.tag()) {
      case StatusDetailsTag::kDetails:
        return in.TakeMessage([&](std::string_view detail) {
          if (reason.empty()) reason = ReasonInDetail(detail);
        });
      default:
        in.Skip();
    }
  });
  return reason;
}

}  // namespace

std::optional<Response> DecodeResponse(std::string_view bytes) {
  try {
    Response response = ReadResponse(bytes);
    if (response.welcome && !HasTextsOfALine(*response.welcome)) return std::nullopt;
    return response;
  } catch (const protozero::exception&) {
    return std::nullopt;
  }
}

std::string ErrorReasonIn(std::string_view status_details) {
  try {
    return ReasonInDetails(status_details);
  } catch (const protozero::exception&) {
    return "";
  }
}

}  // namespace sweepstake::protocol
