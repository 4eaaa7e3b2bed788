#include "server/rpc/services/posteriors_service.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/text/names.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/rpc/services/end_call.h"
#include "server/rpc/services/watch_call.h"
#include "server/sessions/session_table.h"

namespace sweepstake::rpc {
namespace {

using priors::SceneEvidence;
using priors::SceneKey;

// Returns the page token of the key: a protobuf message in hexadecimal digits. KeyOf parses and
// checks it.
std::string TokenOf(const SceneKey& key) {
  v1::ScenePosterior token;
  ToProto(key, token);
  std::string hex;
  for (const char c : token.SerializeAsString()) {
    hex += "0123456789abcdef"[static_cast<unsigned char>(c) >> 4];
    hex += "0123456789abcdef"[static_cast<unsigned char>(c) & 15];
  }
  return hex;
}

std::optional<int> HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return std::nullopt;
}

std::optional<SceneKey> KeyOf(const std::string& token) {
  std::string bytes;
  if (token.size() % 2 != 0) return std::nullopt;
  for (size_t i = 0; i < token.size(); i += 2) {
    const auto high = HexDigit(token[i]);
    const auto low = HexDigit(token[i + 1]);
    if (!high || !low) return std::nullopt;
    bytes += static_cast<char>(*high * 16 + *low);
  }
  v1::ScenePosterior key;
  if (!key.ParseFromString(bytes) || key.project().empty()) return std::nullopt;
  return FromProto(key);
}

uint32_t DefaultRewardVersion(const RpcOptions& options) {
  return decision::RewardVersionOf(
      decision::PolicyKindOf(options.decision.policy, decision::ShippedPolicies()),
      options.decision.weights);
}

}  // namespace

void Answer(ServiceContext& context, const Caller& caller, const v1::ListPosteriorsRequest& request,
            v1::ListPosteriorsResponse& response, const EndCall& end) {
  priors::SceneFilter filter{request.project(), request.scene()};
  if (const absl::Status allowed = Narrow(caller, filter); !allowed.ok()) return end(allowed);
  const std::optional<SceneKey> after = KeyOf(request.page_token());
  if (!after && !request.page_token().empty()) {
    return end(Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                       "page_token is not a next_page_token of this daemon"));
  }
  const uint32_t limit =
      request.page_size() == 0 ? kScenesPerPage : std::min(request.page_size(), kScenesPerPage);
  ReadAndAnswer(
      context, end,
      [filter, after, limit](priors::PriorReader& store) {
        return ToProto(store.List(filter, after, limit));
      },
      [&context, &response, limit](const std::vector<v1::ScenePosterior>& scenes) {
        for (const v1::ScenePosterior& scene : scenes) {
          v1::ScenePosterior& added = *response.add_scenes() = scene;
          ToProto(context.sessions.ActivityOf(FromProto(scene)), added);
        }
        if (scenes.size() == limit) response.set_next_page_token(TokenOf(FromProto(scenes.back())));
        return absl::OkStatus();
      });
}

void Answer(ServiceContext& context, const Caller& caller, const v1::GetPosteriorRequest& request,
            v1::GetPosteriorResponse& response, const EndCall& end) {
  if (const absl::Status allowed = CheckProject(caller, request.project()); !allowed.ok())
    return end(allowed);
  const SceneKey key{request.project(), request.scene(), request.machine_class(),
                     request.reward_version() != 0 ? request.reward_version()
                                                   : DefaultRewardVersion(context.options)};
  if (!text::IsName(key.project) || !text::IsName(key.scene) ||
      !text::IsOptionalName(key.machine_class)) {
    return end(Refused(v1::ERROR_REASON_INVALID_MESSAGE,
                       "project and scene must have 1 to 128 bytes and no control characters"));
  }
  ReadAndAnswer(
      context, end, [key](priors::PriorReader& store) { return store.LoadScene(key); },
      [&context, &response, key](const std::optional<SceneEvidence>& scene) {
        if (!scene)
          return Refused(v1::ERROR_REASON_UNKNOWN_SCENE,
                         "there is no evidence of this scene on this class of machines");
        ToProto(*scene, *response.mutable_scene());
        ToProto(context.sessions.ActivityOf(key), *response.mutable_scene());
        return absl::OkStatus();
      });
}

}  // namespace sweepstake::rpc
