#include "engine_client/decider/embedded/priors_sums.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "engine_client/decider/embedded/field_reader.h"
#include "engine_client/math/hash.h"

namespace sweepstake {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr size_t kMaxSums = 1'000'000;
constexpr char kVersionMark = '/';

std::string Hex(uint64_t number) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(number));
  return digits;
}

// Rounds to five significant digits.
double Rounded(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.5g", value);
  return std::strtod(digits, nullptr);
}

std::string Dump(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

// The checksum of an array of scenes, to which scenes are added one by one.
class Checksum {
 public:
  void Add(const Json& scene) {
    hash_ = math::Fnv1a(math::Fnv1a(hash_, std::exchange(separator_, ",")), scene.dump());
  }

  std::string Text() const { return Hex(math::Fnv1a(hash_, *separator_ == '[' ? "[]" : "]")); }

 private:
  uint64_t hash_ = math::kFnv1aStart;
  const char* separator_ = "[";
};

std::string NameOfSum(const std::string& build) {
  return kSumMark + Hex(math::Fnv1a(math::kFnv1aStart, build));
}

auto SceneOf(const PriorRecord& record) {
  return std::tie(record.key.project, record.key.scene, record.key.machine_class,
                  record.key.reward_version);
}

std::string ArmOf(const PriorRecord& record) {
  return record.key.arm + kVersionMark + std::to_string(record.key.backend_version);
}

OrderedJson CellOf(const PriorRecord& record) {
  OrderedJson cell = {record.evidence.alpha, record.evidence.beta, record.evidence.window_count};
  if (record.evidence.bail_out_count > 0) cell.push_back(record.evidence.bail_out_count);
  return cell;
}

// The evidence of one build in a scene, which becomes one line of the document.
struct BuildLine {
  uint64_t last_seen_unix_s = 0;
  OrderedJson live;
  OrderedJson lane;
};

// The records of one scene on one class of machines.
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
  std::map<std::string, size_t> arms_;  // positions in the cells
  std::map<std::string, BuildLine> lines_;
};

// Reads one scene; keeps the first error.
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
      return SetError("the name of a build must be text of at most 128 bytes");
    const bool whole = line.is_array() && line.size() == 3 && line[0].is_number_unsigned() &&
                       line[1].is_array() && line[2].is_array() &&
                       line[0].get<uint64_t>() <= kMaxSequence && line[1].size() == arms_.size() &&
                       line[2].size() == arms_.size();
    if (!whole) return SetError("a build must be [time, [a cell per arm], [a cell per arm]]");
    common_.build = build;
    common_.source_id = NameOfSum(build);
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
    if (!whole) return SetError("evidence must be [alpha, beta, count] or [.., bail-outs]");
    PriorRecord& sum = sums_.emplace_back(common_);
    std::tie(sum.key.arm, sum.key.backend_version) = arms_[arm];
    sum.evidence.alpha = cell[0].get<double>();
    sum.evidence.beta = cell[1].get<double>();
    sum.evidence.window_count = cell[2].get<uint64_t>();
    sum.evidence.bail_out_count = cell.size() == 4 ? cell[3].get<uint64_t>() : 0;
    sum.source_sequence = std::clamp<uint64_t>(sum.evidence.window_count, 1, kMaxSequence);
    if (!IsIncrement(sum.evidence.alpha) || !IsIncrement(sum.evidence.beta))
      SetError("evidence must be from 0 to 1e15");
  }

  void SetError(std::string what) {
    if (!error_) error_ = std::move(what);
  }

  std::vector<PriorRecord>& sums_;
  PriorRecord common_;
  std::vector<std::pair<std::string, uint32_t>> arms_;
  std::optional<std::string> error_;
};

Status Damaged(const std::string& why) { return {StatusCode::kDataLoss, why}; }

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

// Adds a record with the key of the sum.
void AddTo(PriorRecord& sum, const PriorRecord& record) {
  sum.evidence += record.evidence;
  sum.last_seen_unix_s = std::max(sum.last_seen_unix_s, record.last_seen_unix_s);
}

// A document to which scenes are added one after the other.
class Document {
 public:
  // REQUIRES: all records are sums with distinct keys, and include all sums of their scenes and
  // machine classes.
  void Add(std::span<const PriorRecord> sums) {
    const std::vector<const PriorRecord*> ordered = OrderedBy(SceneOf, sums);
    for (auto from = ordered.begin(); from != ordered.end();) {
      const auto to = std::find_if(from, ordered.end(), [&](const PriorRecord* record) {
        return SceneOf(*record) != SceneOf(**from);
      });
      const std::string scene = SceneText({from, to}).Text();
      checksum_.Add(Json::parse(scene));
      scenes_ += (scenes_.empty() ? "\n" : ",\n") + scene;
      from = to;
    }
  }

  std::string Text() const {
    return "{\"format\":\"sweepstake-priors\",\"version\":2,\"checksum\":\"" + checksum_.Text() +
           "\",\"scenes\":[" + scenes_ + "]}\n";
  }

 private:
  Checksum checksum_;
  std::string scenes_;
};

}  // namespace

std::vector<PriorRecord> SumByBuild(std::vector<PriorRecord> records) {
  std::erase_if(records, [](const PriorRecord& record) { return record.is_quarantined; });
  for (PriorRecord& record : records) {
    record.source_id = NameOfSum(record.build);
    record.source_sequence = 0;
  }
  std::vector<PriorRecord> sums;
  for (const PriorRecord* record : OrderedBy(KeyOf, records)) {
    if (sums.empty() || KeyOf(sums.back()) != KeyOf(*record)) {
      sums.push_back(*record);
    } else {
      AddTo(sums.back(), *record);
    }
  }
  for (PriorRecord& sum : sums) {
    sum.evidence.alpha = Rounded(sum.evidence.alpha);
    sum.evidence.beta = Rounded(sum.evidence.beta);
    sum.source_sequence = std::clamp<uint64_t>(sum.evidence.window_count, 1, kMaxSequence);
  }
  return sums;
}

bool IsSum(const PriorRecord& record) { return record.source_id.starts_with(kSumMark); }

std::string FormatSums(std::span<const PriorRecord> sums) {
  Document document;
  document.Add(sums);
  return document.Text();
}

struct SumsWriter::State {
  void EndScene() {
    const std::vector<PriorRecord> sums = SumByBuild(std::exchange(records, {}));
    document.Add(sums);
    sum_count += sums.size();
  }

  Document document;
  std::vector<PriorRecord> records;  // of the latest scene
  uint64_t sum_count = 0;
};

SumsWriter::SumsWriter() : state_(std::make_unique<State>()) {}
SumsWriter::~SumsWriter() = default;

void SumsWriter::Add(PriorRecord record) {
  std::vector<PriorRecord>& records = state_->records;
  const bool begins = !records.empty() && (records.back().key.scene != record.key.scene ||
                                           records.back().key.project != record.key.project);
  if (begins) state_->EndScene();
  records.push_back(std::move(record));
}

std::string SumsWriter::Finish(uint64_t& sum_count) {
  state_->EndScene();
  sum_count = state_->sum_count;
  return state_->document.Text();
}

struct SumsReader::State {
  Checksum checksum;
  std::vector<PriorRecord> sums;
  std::set<std::tuple<std::string, std::string, std::string, uint32_t>> scenes;
  size_t count = 0;
  std::optional<std::string> error;  // the first one
};

SumsReader::SumsReader() : state_(std::make_unique<State>()) {}
SumsReader::~SumsReader() = default;

void SumsReader::Add(const Json& scene) {
  State& state = *state_;
  state.checksum.Add(scene);
  const size_t index = state.count++;
  if (state.error) return;
  const SceneReader reader(scene, state.sums);
  const auto name = SceneOf(reader.common());
  if (reader.error()) {
    state.error = "priors scene " + std::to_string(index) + ": " + *reader.error();
  } else if (!state.scenes.emplace(name).second) {
    state.error = "priors scene " + std::to_string(index) + ": repeats an earlier one";
  } else if (state.sums.size() > kMaxSums) {
    state.error = "the priors hold more than 1000000 sums";
  }
}

Result<std::vector<PriorRecord>> SumsReader::Take(const Json& document) {
  const auto scenes = document.find("scenes");
  if (scenes == document.end() || !scenes->is_array() || !scenes->empty())
    return Damaged("the priors have no array \"scenes\" of objects");
  if (document.value("checksum", Json()) != state_->checksum.Text())
    return Damaged("the priors have a wrong checksum: the file was changed after it was written");
  if (state_->error) return Damaged(*state_->error);
  return std::move(state_->sums);
}

}  // namespace sweepstake
