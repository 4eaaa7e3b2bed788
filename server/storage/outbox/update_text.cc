#include "server/storage/outbox/update_text.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace sweepstake::storage {
namespace {

using nlohmann::json;

json ToJson(const priors::KeyedEvidence& increment) {
  const auto& [key, evidence] = increment;
  return {{"project", key.project},
          {"scene", key.scene},
          {"measured_by", key.measured_by},
          {"arm", key.arm},
          {"backend_version", key.backend_version},
          {"machine_class", key.machine_class},
          {"reward_version", key.reward_version},
          {"alpha", evidence.alpha},
          {"beta", evidence.beta},
          {"window_count", evidence.window_count},
          {"bail_out_count", evidence.bail_out_count}};
}

priors::KeyedEvidence IncrementIn(const json& item) {
  return {.key = {.project = item.at("project"),
                  .scene = item.at("scene"),
                  .measured_by = item.at("measured_by"),
                  .arm = item.at("arm"),
                  .backend_version = item.at("backend_version"),
                  .machine_class = item.at("machine_class"),
                  .reward_version = item.at("reward_version")},
          .evidence = {.alpha = item.at("alpha"),
                       .beta = item.at("beta"),
                       .window_count = item.at("window_count"),
                       .bail_out_count = item.at("bail_out_count")}};
}

json ToJson(const priors::SourceProgress& progress) {
  return {{"source_id", progress.source_id},
          {"commit_sequence", progress.commit_sequence},
          {"message_sequence", progress.message_sequence},
          {"explored_arm_count", progress.explored_arm_count},
          {"decision_count", progress.decision_count},
          {"frame_count", progress.frame_count},
          {"seed", progress.seed}};
}

priors::SourceProgress ProgressIn(const json& item) {
  return {.source_id = item.at("source_id"),
          .commit_sequence = item.at("commit_sequence"),
          .message_sequence = item.at("message_sequence"),
          .explored_arm_count = item.at("explored_arm_count"),
          .decision_count = item.at("decision_count"),
          .frame_count = item.at("frame_count"),
          .seed = item.at("seed")};
}

json ToJson(const priors::AuditRows& audit) {
  json rows = json::array();
  for (const priors::AuditRow& row : audit.rows) rows.push_back({row.number, row.text});
  return {{"segment", audit.segment},
          {"project", audit.project},
          {"scene", audit.scene},
          {"unix_start_ms", audit.unix_start_ms},
          {"rows", std::move(rows)}};
}

priors::AuditRows AuditIn(const json& item) {
  priors::AuditRows audit{.segment = item.at("segment"),
                          .project = item.at("project"),
                          .scene = item.at("scene"),
                          .unix_start_ms = item.at("unix_start_ms"),
                          .rows = {}};
  for (const json& row : item.at("rows"))
    audit.rows.push_back({.number = row.at(0), .text = row.at(1)});
  return audit;
}

}  // namespace

std::string UpdateText(const priors::SourceUpdate& update) {
  json increments = json::array();
  for (const priors::KeyedEvidence& increment : update.increments)
    increments.push_back(ToJson(increment));
  return json{
      {"progress", ToJson(update.progress)}, {"unix_time_s", update.unix_time_s},
      {"increments", std::move(increments)}, {"audit", ToJson(update.audit)},
      {"build", update.origin.build},        {"token_id", update.origin.token_id},
      {"writer", update.writer.id},          {"resumed_sequence", update.writer.resumed_sequence}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

absl::StatusOr<priors::SourceUpdate> UpdateIn(const std::string& text) {
  try {
    const json item = json::parse(text);
    priors::SourceUpdate update{
        .progress = ProgressIn(item.at("progress")),
        .unix_time_s = item.at("unix_time_s"),
        .increments = {},
        .audit = AuditIn(item.at("audit")),
        .origin = {.build = item.at("build"), .token_id = item.at("token_id")},
        .writer = {.id = item.at("writer"), .resumed_sequence = item.at("resumed_sequence")}};
    for (const json& increment : item.at("increments"))
      update.increments.push_back(IncrementIn(increment));
    return update;
  } catch (const json::exception& error) {
    return absl::DataLossError(error.what());
  }
}

}  // namespace sweepstake::storage
