#include "engine_client/decider/embedded/priors_file.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "engine_client/decider/embedded/field_reader.h"
#include "engine_client/decider/embedded/priors_sums.h"

namespace sweepstake {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFormat = "sweepstake-priors";
constexpr int kVersion = 1;
constexpr int kVersionOfSums = 2;
constexpr uintmax_t kMaxFileBytes = uintmax_t{128} << 20;
constexpr size_t kMaxRecords = 200'000;

Status Broken(const std::string& why) { return {StatusCode::kDataLoss, why}; }

std::optional<std::string> ReadRecord(const Json& json, PriorRecord& record) {
  FieldReader reader(json);
  reader.Name("project", record.key.project, true);
  reader.Name("scene", record.key.scene, true);
  reader.MeasuredBy("measured_by", record.key.measured_by);
  reader.Name("arm", record.key.arm, true);
  reader.Count("backend_version", record.key.backend_version, true);
  reader.Name("machine_class", record.key.machine_class, false);
  reader.Count("reward_version", record.key.reward_version, true);
  reader.Name("source_id", record.source_id, true);
  reader.Count("source_sequence", record.source_sequence, true, kMaxSequence);
  reader.Increment("alpha_increment", record.evidence.alpha);
  reader.Increment("beta_increment", record.evidence.beta);
  reader.Count("window_count", record.evidence.window_count, false);
  reader.Count("bail_out_count", record.evidence.bail_out_count, false);
  reader.Name("build", record.build, false);
  reader.Count("unix_last_seen_s", record.last_seen_unix_s, false, kMaxSequence);
  reader.Flag("is_quarantined", record.is_quarantined);
  reader.RejectUnknown();
  return reader.error();
}

// Returns the first record that has the key of an earlier one.
std::optional<size_t> FirstRepeated(const std::vector<PriorRecord>& records) {
  std::vector<const PriorRecord*> ordered;
  ordered.reserve(records.size());
  for (const PriorRecord& record : records) ordered.push_back(&record);
  std::stable_sort(ordered.begin(), ordered.end(), [](const PriorRecord* a, const PriorRecord* b) {
    return KeyOf(*a) < KeyOf(*b);
  });
  size_t first = records.size();
  for (size_t i = 1; i < ordered.size(); ++i) {
    if (KeyOf(*ordered[i - 1]) == KeyOf(*ordered[i]))
      first = std::min(first, static_cast<size_t>(ordered[i] - records.data()));
  }
  if (first == records.size()) return std::nullopt;
  return first;
}

bool Holds(const Json& document, const char* key, const Json& expected) {
  const auto found = document.find(key);
  return found != document.end() && *found == expected;
}

std::string RecordName(size_t index) { return "priors record " + std::to_string(index); }

// Reads records, which are added one by one as they are parsed.
class RecordsReader {
 public:
  void Add(const Json& json) {
    const size_t index = count_++;
    if (error_ || count_ > kMaxRecords) return;
    const auto error = ReadRecord(json, records_.emplace_back());
    if (error) error_ = RecordName(index) + ": " + *error;
  }

  // Returns all records, once. `document` is the rest of the file, with an empty array in place of
  // the records.
  Result<std::vector<PriorRecord>> Take(const Json& document) {
    const auto array = document.find("records");
    if (array == document.end() || !array->is_array() || !array->empty())
      return Broken("the priors have no array \"records\" of objects");
    if (count_ > kMaxRecords)
      return Broken("the priors hold " + std::to_string(count_) + " records, more than 200000");
    if (error_) return Broken(*error_);
    if (const std::optional<size_t> repeated = FirstRepeated(records_))
      return Broken(RecordName(*repeated) + ": repeats the key and source of an earlier record");
    return std::move(records_);
  }

 private:
  std::vector<PriorRecord> records_;
  size_t count_ = 0;
  std::optional<std::string> error_;  // the first one
};

Json ToJson(const PriorRecord& record) {
  Json json = {{"project", record.key.project},
               {"scene", record.key.scene},
               {"measured_by", record.key.measured_by},
               {"arm", record.key.arm},
               {"backend_version", record.key.backend_version},
               {"machine_class", record.key.machine_class},
               {"reward_version", record.key.reward_version},
               {"source_id", record.source_id},
               {"source_sequence", record.source_sequence},
               {"alpha_increment", record.evidence.alpha},
               {"beta_increment", record.evidence.beta},
               {"window_count", record.evidence.window_count},
               {"bail_out_count", record.evidence.bail_out_count},
               {"build", record.build},
               {"unix_last_seen_s", record.last_seen_unix_s}};
  if (record.is_quarantined) json["is_quarantined"] = true;
  return json;
}

Status Unwritable(const std::filesystem::path& path) {
  return {StatusCode::kUnavailable,
          "cannot write " + path.string() + "; check that the folder exists and has room"};
}

}  // namespace

Result<std::vector<PriorRecord>> ParsePriors(std::string_view text) {
  if (text.size() > kMaxFileBytes) return Broken("the priors are over 128 MiB");
  RecordsReader records;
  SumsReader sums;
  std::string key;
  // Limits memory: each record or scene is read as soon as it is parsed, then removed from the
  // JSON.
  const auto keep = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth == 1 && event == Json::parse_event_t::key) key = parsed.get_ref<std::string&>();
    if (depth != 2 || event != Json::parse_event_t::object_end) return true;
    if (key == "records") records.Add(parsed);
    if (key == "scenes") sums.Add(parsed);
    return key != "records" && key != "scenes";
  };
  const Json document = Json::parse(text, keep, /*allow_exceptions=*/false);
  if (document.is_discarded()) return Broken("the priors are not a JSON document");
  if (!document.is_object() || !Holds(document, "format", kFormat))
    return Broken("the priors are not of format \"sweepstake-priors\"");
  if (Holds(document, "version", kVersionOfSums)) return sums.Take(document);
  if (Holds(document, "version", kVersion)) return records.Take(document);
  return Broken("the priors are not of version 1 or 2, which this build reads");
}

std::string FormatPriors(std::span<const PriorRecord> records) {
  if (!records.empty() && std::all_of(records.begin(), records.end(), IsSum))
    return FormatSums(records);
  std::string text = "{\"format\":\"sweepstake-priors\",\"version\":1,\"records\":[";
  const char* separator = "\n";
  for (const PriorRecord& record : records) {
    text += std::exchange(separator, ",\n");
    text += ToJson(record).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return text + "]}\n";
}

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return Status(StatusCode::kNotFound, "there is no priors file " + path.string());
  }
  const uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMaxFileBytes) return Broken(path.string() + ": over 128 MiB or unreadable");
  std::string text(static_cast<size_t>(bytes), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file || static_cast<uintmax_t>(file.gcount()) != bytes) {
    return Broken(path.string() + ": cannot be read to its end");
  }
  Result<std::vector<PriorRecord>> records = ParsePriors(text);
  if (!records.ok()) return Broken(path.string() + ": " + records.status().message());
  return records;
}

Status WritePriorsFile(std::span<const PriorRecord> records, const std::filesystem::path& path) {
  return WritePriorsText(FormatPriors(records), path);
}

Status WritePriorsText(std::string_view text, const std::filesystem::path& path) {
  std::error_code error;
  // Does not replace a device or a pipe by a file.
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    return Unwritable(path);
  }
  std::filesystem::path partial = path;
  partial += ".partial";
  std::ofstream file(partial, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (file) std::filesystem::rename(partial, path, error);
  if (file && !error) return {};
  std::filesystem::remove(partial, error);
  return Unwritable(path);
}

}  // namespace sweepstake
