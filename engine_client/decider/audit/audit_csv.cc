#include "engine_client/decider/audit/audit_csv.h"

#include <utility>

#include "engine_client/decider/audit/field_text.h"

namespace sweepstake::decision {
namespace {

using Lines = std::vector<std::vector<std::string>>;

constexpr std::ptrdiff_t kKeyColumns = 4;  // item, session, segment, row

// Visits the fields of a row and writes their values, or their names for the header line, into
// cells.
class CellWriter {
 public:
  explicit CellWriter(bool writes_names) : writes_names_(writes_names) {}

  template <typename T>
  void operator()(std::string_view name, const T& value) {
    if constexpr (AuditStruct<const T>) {
      const size_t length = prefix_.size();
      if (writes_names_) prefix_.append(name) += '_';
      VisitFields(value, *this);
      prefix_.resize(length);
    } else if constexpr (kIsOptional<T>) {
      value ? (*this)(name, *value) : Skip<typename T::value_type>(name);
    } else if constexpr (kIsList<T>) {
      const size_t column = column_;
      if (value.empty()) Skip<typename T::value_type>(name);
      for (size_t i = 0; i < value.size(); ++i) {
        column_ = column;
        item_ = i;
        (*this)(name, value[i]);
      }
      item_ = 0;
    } else {
      std::string& cell = Cell();
      if (writes_names_) {
        cell = prefix_ + std::string(name);
      } else if (!skips_) {
        cell = FieldText(value);
      }
    }
  }

  Lines lines() && { return std::move(lines_); }

 private:
  // Advances over the columns of an absent value and leaves their cells empty.
  template <typename T>
  void Skip(std::string_view name) {
    const bool skipped = std::exchange(skips_, true);
    (*this)(name, T{});
    skips_ = skipped;
  }

  std::string& Cell() {
    if (item_ == lines_.size()) {
      std::vector<std::string> key(lines_[0].begin(), lines_[0].begin() + kKeyColumns);
      key[0] = std::to_string(item_);
      lines_.push_back(std::move(key));
    }
    auto& line = lines_[item_];
    if (line.size() <= column_) line.resize(column_ + 1);
    return line[column_++];
  }

  const bool writes_names_;
  Lines lines_{{writes_names_ ? "item" : "0"}};
  size_t column_ = 1;
  size_t item_ = 0;
  bool skips_ = false;
  std::string prefix_;
};

Lines LinesOf(const AuditRow& row, bool writes_names) {
  CellWriter writer(writes_names);
  VisitFields(row, writer);
  Lines lines = std::move(writer).lines();
  for (auto& line : lines) line.resize(lines.front().size());
  return lines;
}

}  // namespace

const std::vector<std::string>& AuditColumns() {
  static const std::vector<std::string> columns = LinesOf({}, /*writes_names=*/true).front();
  return columns;
}

Lines AuditCells(const AuditRow& row) { return LinesOf(row, /*writes_names=*/false); }

std::string AuditHeader() {
  std::string text;
  text::AppendCsvLine(text, AuditColumns());
  return text;
}

std::string AuditLines(const AuditRow& row) {
  std::string text;
  for (const auto& line : AuditCells(row)) {
    if (!text.empty()) text += '\n';
    text::AppendCsvLine(text, line);
  }
  return text;
}

}  // namespace sweepstake::decision
