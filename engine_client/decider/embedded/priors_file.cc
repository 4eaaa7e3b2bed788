#include "engine_client/decider/embedded/priors_file.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/math/hash.h"
#include "engine_client/text/names.h"

namespace sweepstake {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kFormat = "sweepstake-priors";
constexpr int kVersion = 1;
constexpr uintmax_t kMaxFileBytes = uintmax_t{128} << 20;
constexpr size_t kReadBytes = size_t{1} << 20;
constexpr size_t kMaxRecords = 200'000;
constexpr size_t kMaxSums = 1'000'000;
// Maximum of counts and sequence numbers, as in the store. It leaves room below UINT64_MAX, so the
// ledger's next sequence number cannot wrap to 0.
constexpr uint64_t kMaxCount = std::numeric_limits<int64_t>::max();
constexpr char kVersionMark = '/';

Status Broken(const std::string& why) { return {StatusCode::kDataLoss, why}; }

std::string TooManyRecords(size_t count) {
  return std::to_string(count) +
         " records are more than a priors file may have, 200000; export sums of builds (--sums), "
         "one project (--project) or one scene (--scene)";
}

// Returns false for NaN, negative values and values above 1e15.
bool IsIncrement(double value) { return value >= 0 && value <= 1e15; }

// Reads the fields of one object; keeps the first error.
class FieldReader {
 public:
  explicit FieldReader(const nlohmann::json& object) : object_(object) {}

  void Name(const char* key, std::string& value, bool required) {
    const nlohmann::json* field = Find(key, required);
    if (field == nullptr) return;
    if (!field->is_string()) return SetError(key, "is not a string");
    value = field->get_ref<const std::string&>();
    if (required && value.empty()) return SetError(key, "is empty");
    if (!text::IsOptionalName(value)) {
      SetError(key, "is over 128 bytes or holds a control character");
    }
  }

  void MeasuredBy(const char* key, std::string& value) {
    Name(key, value, false);
    if (!decision::IsMeasuredBy(value)) SetError(key, "must be absent or \"lane\"");
  }

  void Regime(const char* key, std::string& value) {
    Name(key, value, false);
    if (!decision::MiddleOf(value)) SetError(key, "must be absent or numbers such as 13/-4/0");
  }

  // Reads an optional true or false; if the field is absent, `value` keeps its value.
  void Flag(const char* key, bool& value) {
    const nlohmann::json* field = Find(key, /*required=*/false);
    if (field == nullptr) return;
    if (!field->is_boolean()) return SetError(key, "must be true or false");
    value = field->get<bool>();
  }

  template <typename Integer>
  void Count(const char* key, Integer& value, bool required,
             Integer max = std::numeric_limits<Integer>::max()) {
    const nlohmann::json* field = Find(key, required);
    if (field == nullptr) return;
    if (!field->is_number_unsigned()) return SetError(key, "is not a whole number >= 0");
    const uint64_t number = field->get<uint64_t>();
    if (number > max) return SetError(key, "is too large");
    if (required && number == 0) return SetError(key, "is 0");
    value = static_cast<Integer>(number);
  }

  void Increment(const char* key, double& value) {
    const nlohmann::json* field = Find(key, true);
    if (field == nullptr) return;
    if (!field->is_number()) return SetError(key, "is not a number");
    value = field->get<double>();
    if (!IsIncrement(value)) SetError(key, "must be from 0 to 1e15");
  }

  // Returns the field. It must be an array if `array` is true, else an object; otherwise returns
  // null and sets the error.
  const nlohmann::json* Structured(const char* key, bool array) {
    const nlohmann::json* field = Find(key, true);
    if (field == nullptr) return nullptr;
    if (array ? field->is_array() : field->is_object()) return field;
    SetError(key, array ? "is not an array" : "is not an object");
    return nullptr;
  }

  // Sets an error if the object has a field that was not read. Call it after reading all fields.
  void RejectUnknown() {
    for (const auto& item : object_.items()) {
      if (!known_.contains(item.key())) return SetError(item.key(), "is an unknown field");
    }
  }

  const std::optional<std::string>& error() const { return error_; }

 private:
  const nlohmann::json* Find(const char* key, bool required) {
    known_.insert(key);
    const auto found = object_.find(key);
    if (found != object_.end()) return &*found;
    if (required) SetError(key, "is missing");
    return nullptr;
  }

  void SetError(const std::string& key, const char* what) {
    if (!error_) error_ = key.substr(0, text::kMaxNameBytes) + " " + what;
  }

  const nlohmann::json& object_;
  std::set<std::string> known_;
  std::optional<std::string> error_;
};

std::optional<std::string> ReadRecord(const Json& json, PriorRecord& record) {
  FieldReader reader(json);
  reader.Name("project", record.key.project, true);
  reader.Name("scene", record.key.scene, true);
  reader.Regime("regime", record.key.regime);
  reader.MeasuredBy("measured_by", record.key.measured_by);
  reader.Name("arm", record.key.arm, true);
  reader.Count("backend_version", record.key.backend_version, true);
  reader.Name("machine_class", record.key.machine_class, false);
  reader.Count("reward_version", record.key.reward_version, true);
  reader.Name("source_id", record.source_id, true);
  reader.Count("source_sequence", record.source_sequence, true, kMaxCount);
  reader.Increment("alpha_increment", record.evidence.alpha);
  reader.Increment("beta_increment", record.evidence.beta);
  reader.Count("window_count", record.evidence.window_count, false, kMaxCount);
  reader.Count("bail_out_count", record.evidence.bail_out_count, false, kMaxCount);
  reader.Name("build", record.build, false);
  reader.Count("unix_last_seen_s", record.last_seen_unix_s, false, kMaxCount);
  reader.Flag("is_quarantined", record.is_quarantined);
  reader.RejectUnknown();
  if (!reader.error() && IsSum(record)) return "source_id must not begin with *, which marks sums";
  return reader.error();
}

// Returns pointers to the records, ordered by key(record).
template <typename Key>
std::vector<const PriorRecord*> OrderedBy(Key key, std::span<const PriorRecord> records) {
  std::vector<const PriorRecord*> ordered;
  ordered.reserve(records.size());
  for (const PriorRecord& record : records) ordered.push_back(&record);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [&](const PriorRecord* a, const PriorRecord* b) { return key(*a) < key(*b); });
  return ordered;
}

// Returns the index of the first record whose KeyOf an earlier record has too.
std::optional<size_t> FirstRepeated(std::span<const PriorRecord> records) {
  const std::vector<const PriorRecord*> ordered = OrderedBy(KeyOf, records);
  size_t first = records.size();
  for (size_t i = 1; i < ordered.size(); ++i) {
    if (KeyOf(*ordered[i - 1]) == KeyOf(*ordered[i]))
      first = std::min(first, static_cast<size_t>(ordered[i] - records.data()));
  }
  if (first == records.size()) return std::nullopt;
  return first;
}

// Parses the array "records". The JSON parser passes its elements one by one.
class RecordsReader {
 public:
  void Add(const Json& json) {
    const size_t index = count_++;
    if (error_ || count_ > kMaxRecords) return;
    const auto error = ReadRecord(json, records_.emplace_back());
    if (error) error_ = Name(index) + ": " + *error;
  }

  // Returns all records, or the first error. Call it once.
  Result<std::vector<PriorRecord>> Take() {
    if (count_ > kMaxRecords) return Broken(TooManyRecords(count_));
    if (error_) return Broken(*error_);
    if (const std::optional<size_t> repeated = FirstRepeated(records_))
      return Broken(Name(*repeated) + ": repeats the key and source of an earlier record");
    return std::move(records_);
  }

 private:
  static std::string Name(size_t index) { return "priors record " + std::to_string(index); }

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
  if (!record.key.regime.empty()) json["regime"] = record.key.regime;
  if (record.is_quarantined) json["is_quarantined"] = true;
  return json;
}

std::string Dump(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

// Computes the checksum of an array of scenes, to which scenes are added one by one.
class Checksum {
 public:
  void Add(const Json& scene) {
    hash_ = math::Fnv1a(math::Fnv1a(hash_, std::exchange(separator_, ",")), scene.dump());
  }

  std::string Text() const {
    return math::HexOf(math::Fnv1a(hash_, *separator_ == '[' ? "[]" : "]"));
  }

 private:
  uint64_t hash_ = math::kFnv1aStart;
  const char* separator_ = "[";
};

auto SceneOf(const PriorRecord& record) {
  return std::tie(record.key.project, record.key.scene, record.key.machine_class,
                  record.key.reward_version, record.key.regime);
}

std::string ArmOf(const PriorRecord& record) {
  return record.key.arm + kVersionMark + std::to_string(record.key.backend_version);
}

// Rounds to five significant digits.
double Rounded(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.5g", value);
  return std::strtod(digits, nullptr);
}

OrderedJson CellOf(const PriorRecord& record) {
  OrderedJson cell = {Rounded(record.evidence.alpha), Rounded(record.evidence.beta),
                      record.evidence.window_count};
  if (record.evidence.bail_out_count > 0) cell.push_back(record.evidence.bail_out_count);
  return cell;
}

// The line of the file for one build of the game, within a scene.
struct BuildLine {
  uint64_t last_seen_unix_s = 0;
  OrderedJson live;
  OrderedJson lane;
};

// Writes the text of one scene on one class of machines.
class SceneText {
 public:
  explicit SceneText(std::span<const PriorRecord* const> records) : first_(*records.front()) {
    for (const PriorRecord* record : records) arms_.emplace(ArmOf(*record), 0);
    size_t next = 0;
    for (auto& [arm, index] : arms_) index = next++;
    for (const PriorRecord* record : records) Add(*record);
  }

  std::string Text() const {
    OrderedJson head = {{"project", first_.key.project},
                        {"scene", first_.key.scene},
                        {"machine_class", first_.key.machine_class},
                        {"reward_version", first_.key.reward_version}};
    if (!first_.key.regime.empty()) head["regime"] = first_.key.regime;
    for (const auto& [arm, index] : arms_) head["arms"].push_back(arm);
    std::string text = Dump(head);
    text.back() = ',';
    text += "\"builds\":{";
    const char* separator = "\n";
    for (const auto& [build, line] : lines_) {
      text += separator + Dump(build) + ":" + Dump({line.last_seen_unix_s, line.live, line.lane});
      separator = ",\n";
    }
    return text + "}}";
  }

 private:
  void Add(const PriorRecord& record) {
    BuildLine& line = lines_[record.build];
    line.last_seen_unix_s = std::max(line.last_seen_unix_s, record.last_seen_unix_s);
    for (OrderedJson* cells : {&line.live, &line.lane}) {
      if (cells->is_null()) *cells = OrderedJson(OrderedJson::array_t(arms_.size()));
    }
    OrderedJson& cells = record.key.measured_by.empty() ? line.live : line.lane;
    cells[arms_.at(ArmOf(record))] = CellOf(record);
  }

  const PriorRecord& first_;
  std::map<std::string, size_t> arms_;  // index of each arm's cell in the line of a build
  std::map<std::string, BuildLine> lines_;
};

// Parses one element of the array "scenes"; keeps the first error.
class SceneReader {
 public:
  SceneReader(const Json& scene, std::vector<PriorRecord>& sums) : sums_(sums) {
    if (!scene.is_object()) {
      SetError("is not an object");
      return;
    }
    FieldReader fields(scene);
    fields.Name("project", common_.key.project, true);
    fields.Name("scene", common_.key.scene, true);
    fields.Name("machine_class", common_.key.machine_class, false);
    fields.Count("reward_version", common_.key.reward_version, true);
    fields.Regime("regime", common_.key.regime);
    const Json* const arms = fields.Structured("arms", /*array=*/true);
    const Json* const builds = fields.Structured("builds", /*array=*/false);
    fields.RejectUnknown();
    error_ = fields.error();
    if (arms == nullptr || builds == nullptr) return;
    for (const Json& arm : *arms) ReadArm(arm);
    for (const auto& [build, line] : builds->items()) {
      if (!error_) ReadBuild(build, line);
    }
  }

  const std::optional<std::string>& error() const { return error_; }
  const PriorRecord& common() const { return common_; }  // the fields that all records share

 private:
  void ReadArm(const Json& arm) {
    const std::string text = arm.is_string() ? arm.get<std::string>() : "";
    const size_t mark = text.rfind(kVersionMark);
    if (mark == std::string::npos) return SetError("an arm must be NAME/VERSION");
    std::pair<std::string, uint32_t>& read = arms_.emplace_back(text.substr(0, mark), 0);
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + mark + 1, end, read.second);
    if (error != std::errc() || stop != end || read.second == 0 || !text::IsName(read.first))
      SetError("an arm must be NAME/VERSION");
    if (std::find(arms_.begin(), arms_.end() - 1, read) != arms_.end() - 1)
      SetError("repeats an arm");
  }

  void ReadBuild(const std::string& build, const Json& line) {
    if (!text::IsOptionalName(build))
      return SetError(
          "the name of a build must have at most 128 bytes of UTF-8 and no control characters");
    const bool whole = line.is_array() && line.size() == 3 && line[0].is_number_unsigned() &&
                       line[1].is_array() && line[2].is_array() &&
                       line[0].get<uint64_t>() <= kMaxCount && line[1].size() == arms_.size() &&
                       line[2].size() == arms_.size();
    if (!whole)
      return SetError(
          "a build must be [Unix time, [live evidence per arm], [lane evidence per arm]]");
    common_.build = build;
    common_.last_seen_unix_s = line[0].get<uint64_t>();
    for (size_t by_lane = 0; by_lane < 2; ++by_lane) {
      common_.key.measured_by = by_lane == 1 ? decision::kLaneName : "";
      for (size_t arm = 0; arm < arms_.size(); ++arm) ReadCell(arm, line[1 + by_lane][arm]);
    }
  }

  void ReadCell(size_t arm, const Json& cell) {
    if (cell.is_null()) return;
    const bool whole = cell.is_array() && (cell.size() == 3 || cell.size() == 4) &&
                       cell[0].is_number() && cell[1].is_number() && cell[2].is_number_unsigned() &&
                       cell.back().is_number_unsigned();
    if (!whole)
      return SetError("evidence must be [alpha, beta, count] or [alpha, beta, count, bail-outs]");
    PriorRecord& sum = sums_.emplace_back(common_);
    std::tie(sum.key.arm, sum.key.backend_version) = arms_[arm];
    sum.evidence.alpha = cell[0].get<double>();
    sum.evidence.beta = cell[1].get<double>();
    sum.evidence.window_count = cell[2].get<uint64_t>();
    sum.evidence.bail_out_count = cell.size() == 4 ? cell[3].get<uint64_t>() : 0;
    MarkAsSum(sum);
    if (std::max(sum.evidence.window_count, sum.evidence.bail_out_count) > kMaxCount)
      SetError("a count is too large");
    if (!IsIncrement(sum.evidence.alpha) || !IsIncrement(sum.evidence.beta))
      SetError("alpha and beta must be from 0 to 1e15");
  }

  void SetError(std::string what) {
    if (!error_) error_ = std::move(what);
  }

  std::vector<PriorRecord>& sums_;
  PriorRecord common_;
  std::vector<std::pair<std::string, uint32_t>> arms_;
  std::optional<std::string> error_;
};

// Parses the array "scenes". The JSON parser passes its elements one by one.
class ScenesReader {
 public:
  void Add(const Json& json) {
    checksum_.Add(json);
    const size_t index = count_++;
    if (error_) return;
    const SceneReader reader(json, sums_);
    if (reader.error()) {
      error_ = Name(index) + ": " + *reader.error();
    } else if (!scenes_.emplace(SceneOf(reader.common())).second) {
      error_ = Name(index) +
               ": repeats the project, scene, machine class, reward version and regime of an "
               "earlier one";
    } else if (sums_.size() > kMaxSums) {
      error_ = "the priors hold more than 1000000 sums";
    }
  }

  // Appends the sums of all scenes, or returns the first error. Call it once.
  Status AppendTo(std::vector<PriorRecord>& records, const Json& checksum) {
    if (checksum != checksum_.Text())
      return Broken(
          "the priors were changed after they were written: their checksum does not match");
    if (error_) return Broken(*error_);
    records.insert(records.end(), std::make_move_iterator(sums_.begin()),
                   std::make_move_iterator(sums_.end()));
    return {};
  }

 private:
  static std::string Name(size_t index) { return "priors scene " + std::to_string(index); }

  Checksum checksum_;
  std::vector<PriorRecord> sums_;
  std::set<std::tuple<std::string, std::string, std::string, uint32_t, std::string>> scenes_;
  size_t count_ = 0;
  std::optional<std::string> error_;  // the first one
};

// Returns the member `"scenes": [...]` with its checksum. REQUIRES: `sums` is not empty.
std::string TextOfScenes(std::span<const PriorRecord> sums) {
  Checksum checksum;
  std::string scenes;
  const std::vector<const PriorRecord*> ordered = OrderedBy(SceneOf, sums);
  for (auto from = ordered.begin(); from != ordered.end();) {
    const auto to = std::find_if(from, ordered.end(), [&](const PriorRecord* record) {
      return SceneOf(*record) != SceneOf(**from);
    });
    const std::string scene = SceneText({from, to}).Text();
    checksum.Add(Json::parse(scene));
    scenes += (scenes.empty() ? "\n" : ",\n") + scene;
    from = to;
  }
  return ",\"checksum\":\"" + checksum.Text() + "\",\"scenes\":[" + scenes + "]";
}

// Returns whether the document has this array. The parser callback has already read and removed its
// elements, so the array must now be empty.
Result<bool> HasArray(const Json& document, const char* name) {
  const auto found = document.find(name);
  if (found == document.end()) return false;
  if (found->is_array() && found->empty()) return true;
  return Broken(std::string("in the priors, \"") + name + "\" must be an array of objects");
}

}  // namespace

Result<std::vector<PriorRecord>> ParsePriors(std::string_view text) {
  if (text.size() > kMaxFileBytes) return Broken("the priors are over 128 MiB");
  RecordsReader records;
  ScenesReader scenes;
  std::string key;
  // Limits memory: each record or scene is read as soon as it is parsed, then removed from the
  // JSON.
  const auto keep = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth == 1 && event == Json::parse_event_t::key) key = parsed.get_ref<std::string&>();
    if (depth != 2 || event != Json::parse_event_t::object_end) return true;
    if (key == "records") records.Add(parsed);
    if (key == "scenes") scenes.Add(parsed);
    return key != "records" && key != "scenes";
  };
  const Json document = Json::parse(text, keep, /*allow_exceptions=*/false);
  if (document.is_discarded()) return Broken("the priors are not a JSON document");
  if (!document.is_object() || document.value("format", Json()) != kFormat)
    return Broken("the priors do not have the format \"sweepstake-priors\"");
  if (document.value("version", Json()) != kVersion)
    return Broken("the priors do not have version 1, the only version that this build reads");
  const Result<bool> has_records = HasArray(document, "records");
  if (!has_records.ok()) return has_records.status();
  const Result<bool> has_scenes = HasArray(document, "scenes");
  if (!has_scenes.ok()) return has_scenes.status();
  if (!*has_records && !*has_scenes)
    return Broken("the priors have neither \"records\" nor \"scenes\"");
  Result<std::vector<PriorRecord>> read = records.Take();
  if (!read.ok() || !*has_scenes) return read;
  const Status status = scenes.AppendTo(*read, document.value("checksum", Json()));
  if (!status.ok()) return status;
  return read;
}

Status CheckRecordCount(std::span<const PriorRecord> records) {
  const auto count = static_cast<size_t>(
      std::count_if(records.begin(), records.end(), [](const auto& each) { return !IsSum(each); }));
  return count > kMaxRecords ? Status(StatusCode::kResourceExhausted, TooManyRecords(count))
                             : Status();
}

std::string FormatPriors(std::span<const PriorRecord> records) {
  std::string text = "{\"format\":\"sweepstake-priors\",\"version\":1,\"records\":[";
  std::vector<PriorRecord> sums;
  const char* separator = "\n";
  for (const PriorRecord& record : records) {
    if (IsSum(record)) {
      sums.push_back(record);
      continue;
    }
    text += std::exchange(separator, ",\n");
    text += ToJson(record).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return text + "]" + (sums.empty() ? "" : TextOfScenes(sums)) + "}\n";
}

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path) {
  std::error_code error;
  const auto found = std::filesystem::status(path, error);
  if (!std::filesystem::exists(found) || std::filesystem::is_directory(found)) {
    return Status(StatusCode::kNotFound, "there is no priors file " + path.string());
  }
  std::ifstream file(path, std::ios::binary);
  std::string text;
  while (file && text.size() <= kMaxFileBytes) {  // a pipe has no size
    const size_t before = text.size();
    text.resize(before + kReadBytes);
    file.read(text.data() + before, kReadBytes);
    text.resize(before + static_cast<size_t>(file.gcount()));
  }
  if (text.size() > kMaxFileBytes) return Broken(path.string() + ": is over 128 MiB");
  if (!file.eof()) return Broken(path.string() + ": cannot be read to its end");
  Result<std::vector<PriorRecord>> records = ParsePriors(text);
  if (!records.ok()) return Broken(path.string() + ": " + records.status().message());
  return records;
}

}  // namespace sweepstake
